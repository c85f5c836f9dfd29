"""Rays into a scene: what they hit, and in what colour."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact
from fsel.core.geometry import lengths
from fsel.synthetic import hierarchy, textures
from fsel.synthetic.solids import Scene

EPSILON = 1e-3  # metres that a shadow ray starts off its surface
HAZE = np.float32(1 / 150)  # one over the metres at which 63 % of a colour is air


@exact
def _surface(solid, origins, rays, which, distance, outwards):
    """Points (m, 3) that the `solid` rays hit, and unit normals (m, 3) towards the camera."""
    points = np.empty((len(solid), 3), np.float32)
    normals = np.empty_like(points)
    for k, i in enumerate(solid):
        normal, ray = outwards[which[i]], rays[i]
        behind = normal[0] * ray[0] + normal[1] * ray[1] + normal[2] * ray[2] > 0
        for c in range(3):
            points[k, c] = origins[i, c] + ray[c] * distance[i]
            normals[k, c] = -normal[c] if behind else normal[c]
    return points, normals


class Caster:
    """A scene ready for rays, in float32 (0.01 mm at 100 m)."""

    def __init__(self, scene: Scene) -> None:
        triangles, self.kinds, self._objects, self.table = scene.finish()
        self.scene = scene
        self.light = scene.light.astype(np.float32)
        self._tree = hierarchy.build(triangles)
        a, b, c = triangles.transpose(1, 0, 2)
        outwards = np.cross(b - a, c - a)
        self.outwards = outwards / lengths(outwards)[:, None]

    def hit(self, origins: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (n,) triangle numbers, -1 for none, and (n,) distances along unit rays, metres."""
        return hierarchy.first_hit(self._tree, origins, rays)

    def objects(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Return (n,) uint8 numbers of the objects that rays first meet, 0 for none."""
        which, _ = self.hit(origins, rays)
        return np.where(which >= 0, self._objects[which], np.uint8(0))

    def colors(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Return (n, 3) float32 linear colours in 0..1 seen along (n, 3) unit rays."""
        which, distance = self.hit(origins, rays)
        solid = np.flatnonzero(which >= 0)
        out = np.zeros((len(rays), 3), np.float32)
        if self.scene.outdoor and len(solid) < len(rays):
            empty = np.flatnonzero(which < 0)
            out[empty] = textures.sky(rays[empty], int(self.table[0, 11]))
        points, normals = _surface(solid, origins, rays, which, distance, self.outwards)
        towards, lit = self._lit(points + normals * np.float32(EPSILON), normals)
        shaded = np.empty_like(points)
        ambient = np.float32(self.scene.ambient)
        kinds = self.kinds[which[solid]]
        textures.shade(
            points, normals, rays[solid], kinds, towards, lit, self.table, ambient, shaded
        )
        if self.scene.outdoor:
            shaded += (textures.HORIZON - shaded) * -np.expm1(-distance[solid, None] * HAZE)
        out[solid] = shaded
        return out

    def _lit(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (n, 3) unit directions to the light, and (n,) whether it shines on a surface
        there; no ray is cast from those that face away."""
        if self.scene.outdoor:
            towards = np.tile(self.light, (len(points), 1))
            reach = np.full(len(points), np.inf, np.float32)
        else:
            towards = self.light - points
            reach = lengths(towards)
            towards /= reach[:, None]
        facing = np.flatnonzero(np.einsum("ni,ni->n", normals, towards) > 0)
        lit = np.zeros(len(points), bool)
        if len(facing):
            shadow = points[facing], towards[facing], reach[facing]
            lit[facing] = ~hierarchy.occluded(self._tree, *shadow)
        return towards, lit

    def clearance(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return (n,) least distance from (n, 3) points to a surface, over (d, 3) directions; 0
        within a solid, where the back of a triangle is seen."""
        origins = np.repeat(points.astype(np.float32), len(directions), axis=0)
        rays = np.tile(directions.astype(np.float32), (len(points), 1))
        which, distance = self.hit(origins, rays)
        behind = np.einsum("ni,ni->n", self.outwards[which], rays) > 0
        distance = np.where(which < 0, np.inf, np.where(behind, 0, distance))
        return distance.reshape(len(points), -1).min(axis=1)
