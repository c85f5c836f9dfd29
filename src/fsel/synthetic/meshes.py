"""Closed triangle meshes of simple solids, their normals outwards.

A mesh library has them too, and takes longer to import than a capture takes to film; the tests hold
these against one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

GOLDEN = (1 + np.sqrt(5)) / 2
# corners of a unit cube, counted in binary by x, y, z; two triangles a side
CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


@dataclass(frozen=True)
class Mesh:
    """A closed surface."""

    vertices: np.ndarray  # (v, 3) float64, metres
    faces: np.ndarray  # (f, 3) int64 rows of `vertices`, counter-clockwise as seen from outside

    @property
    def triangles(self) -> np.ndarray:
        """(f, 3, 3) their corners."""
        return self.vertices[self.faces]

    def scaled(self, factors) -> Mesh:
        """Stretch along x, y and z by positive factors."""
        return Mesh(self.vertices * np.asarray(factors, float), self.faces)

    def placed(self, at, turn: float) -> Mesh:
        """Turn about the z axis by radians, then move."""
        c, s = np.cos(turn), np.sin(turn)
        turned = self.vertices @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        return Mesh(turned + np.asarray(at, float), self.faces)

    def lying(self) -> Mesh:
        """Make a quarter turn about the y axis: what was up points along x."""
        x, y, z = self.vertices.T
        return Mesh(np.column_stack([z, y, -x]), self.faces)


def box(size) -> Mesh:
    """Make a (width, depth, height) box about the origin."""
    return Mesh(CUBE * np.asarray(size, float), _halved(SIDES))


def gable(size) -> Mesh:
    """Make a roof over a (width, depth) base in z = 0, its ridge along y at a height."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    corners = [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0), (0, -y, z), (0, y, z)]
    slopes_and_floor = _halved(((0, 3, 2, 1), (1, 2, 5, 4), (3, 0, 4, 5)))
    return Mesh(np.array(corners, float), np.vstack([slopes_and_floor, [(0, 1, 4), (2, 3, 5)]]))


def lathe(profile, sections: int) -> Mesh:
    """Turn a (p, 2) profile of radius and height, from axis to axis, about the z axis."""
    radius, height = np.asarray(profile, float).T
    angle = np.linspace(0, 2 * np.pi, sections, endpoint=False)[:, None]
    rings = [radius * np.cos(angle), radius * np.sin(angle), np.tile(height, (sections, 1))]
    here = np.arange(sections)[:, None] * len(radius) + np.arange(len(radius) - 1)
    there = np.roll(here, -1, axis=0)
    below = np.stack([here, there, here + 1], axis=-1)[:, radius[:-1] > 0]
    above = np.stack([there, there + 1, here + 1], axis=-1)[:, radius[1:] > 0]
    faces = np.vstack([below.reshape(-1, 3), above.reshape(-1, 3)])
    return Mesh(np.stack(rings, axis=-1).reshape(-1, 3), faces)


def cylinder(radius: float, height: float, sections: int = 24) -> Mesh:
    """Make a cylinder about the z axis and the origin."""
    top = height / 2
    return lathe([(0, -top), (radius, -top), (radius, top), (0, top)], sections)


@cache
def sphere(subdivisions: int) -> Mesh:
    """A unit sphere: an icosahedron whose triangles are quartered, new corners pushed outwards."""
    short, long = np.array([1, GOLDEN]) / np.hypot(1, GOLDEN)
    first = [(i * short, j * long, 0.0) for i in (-1, 1) for j in (-1, 1)]
    vertices = np.array([np.roll(corner, turn) for turn in range(3) for corner in first])
    # its faces: three corners an edge apart each, outwards
    apart = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    near = np.isclose(apart, apart[apart > 0].min())
    threes = np.argwhere(near[:, :, None] & near[:, None] & near[None])
    outwards = np.linalg.det(vertices[threes]) > 0
    faces = threes[outwards & (threes[:, 0] < threes[:, 1:].min(axis=1))]
    for _ in range(subdivisions):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        unique, middle = np.unique(edges, axis=0, return_inverse=True)
        new = vertices[unique].sum(axis=1)
        new /= np.linalg.norm(new, axis=1, keepdims=True)
        ab, bc, ca = (middle.reshape(-1, 3) + len(vertices)).T
        a, b, c = faces.T
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        vertices = np.vstack([vertices, new])
        faces = np.vstack([np.column_stack(part) for part in parts])
    return Mesh(vertices, faces)


def _halved(sides) -> np.ndarray:
    """Two triangles for each side of four corners."""
    return np.array([three for a, b, c, d in sides for three in ((a, b, c), (a, c, d))])
