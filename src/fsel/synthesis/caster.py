"""Rays into a scene: what they hit, and in what colour."""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from fsel.synthesis import textures
from fsel.synthesis.scenes import Scene

EPSILON = 1e-3  # metres that a shadow ray starts off its surface


class Caster:
    """A scene ready for rays; float32, as the ray library is (0.01 mm at 100 m)."""

    def __init__(self, scene: Scene) -> None:
        triangles, self.kinds, self.table = scene.finish()
        self.scene = scene
        self.sun = scene.sun.astype(np.float32)
        self._embree = rtcore_scene.EmbreeScene()
        TriangleMesh(self._embree, triangles)

    def hit(self, origins: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) triangle numbers, -1 for none, and (n,) distances along unit rays, metres."""
        found = self._embree.run(origins, rays, output=1)
        return found["primID"], found["tfar"]

    def colors(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """(n, 3) float32 linear colours in 0..1 seen along (n, 3) unit rays."""
        found = self._embree.run(origins, rays, output=1)
        which = found["primID"]
        solid = which >= 0
        out = np.zeros((len(rays), 3), np.float32)
        if not solid.all():
            empty = np.zeros(((~solid).sum(), 3), np.float32)
            if self.scene.outdoor:
                textures.sky(rays[~solid], int(self.table[0, 11]), empty)
            out[~solid] = empty
        normals = found["Ng"][solid]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        along = rays[solid]
        normals *= -np.sign(np.einsum("ni,ni->n", normals, along))[:, None]
        points = origins[solid] + along * found["tfar"][solid, None]
        shaded = np.empty_like(points)
        lit = self._lit(points + normals * np.float32(EPSILON))
        textures.shade(
            points,
            normals,
            along,
            self.kinds[which[solid]],
            lit,
            self.table,
            self.sun,
            np.float32(self.scene.ambient),
            shaded,
        )
        out[solid] = shaded
        return out

    def _lit(self, points: np.ndarray) -> np.ndarray:
        """Outdoors, whether the sun is unobstructed; a room is lit by its ceiling throughout."""
        if not self.scene.outdoor:
            return np.ones(len(points), dtype=bool)
        towards = np.broadcast_to(self.sun, points.shape)
        return self.hit(points, np.ascontiguousarray(towards))[0] < 0

    def clearance(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """(n,) least distance from (n, 3) points to a surface, over (d, 3) directions."""
        origins = np.repeat(points.astype(np.float32), len(directions), axis=0)
        rays = np.tile(directions.astype(np.float32), (len(points), 1))
        which, distance = self.hit(origins, rays)
        distance = np.where(which < 0, np.inf, distance)
        return distance.reshape(len(points), -1).min(axis=1)
