"""A scene under construction: solids, their materials, and natural colours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from fsel.synthetic import meshes
from fsel.synthetic import textures as tx
from fsel.synthetic.meshes import Mesh

# Hue, saturation and value of what places are made of.
WOOD = (0.08, 0.38, 0.62)
OAK = (0.09, 0.3, 0.75)
PLASTER = (0.11, 0.12, 0.86)
BRICKWORK = (0.045, 0.3, 0.66)
STONE = (0.1, 0.12, 0.68)
MARBLE = (0.09, 0.08, 0.86)
BRONZE = (0.1, 0.3, 0.5)
SLATE = (0.6, 0.14, 0.48)
TERRACOTTA = (0.05, 0.36, 0.68)
GLASS = (0.58, 0.22, 0.4)
GRASS = (0.21, 0.36, 0.56)
FOLIAGE = (0.25, 0.42, 0.52)
CLOTHS = ((0.02, 0.3, 0.6), (0.1, 0.24, 0.75), (0.59, 0.22, 0.57), (0.3, 0.16, 0.57))
PAINTS = (PLASTER, (0.58, 0.1, 0.76), (0.25, 0.09, 0.74), (0.05, 0.12, 0.8), (0.12, 0.18, 0.8))

Tint = tuple[float, float, float]


@dataclass
class Scene:
    """A growing list of solids; `finish` makes the arrays that the ray caster wants."""

    rng: np.random.Generator  # the only source of chance
    light: np.ndarray  # (3,) unit direction towards the sun outdoors; a lamp's place in a room, m
    ambient: float  # light that reaches every surface
    outdoor: bool  # whether rays that hit nothing see a sky
    meshes: list[Mesh] = field(default_factory=list)
    materials: list[np.ndarray] = field(default_factory=list)
    # number of an object -> its meshes; 1 is what a capture is about, if anything
    objects: dict[int, range] = field(default_factory=dict)

    @contextmanager
    def as_object(self, number: int) -> Iterator[None]:
        """Make what is added within the block an object of its own."""
        start = len(self.meshes)
        yield
        self.objects[number] = range(start, len(self.meshes))

    def add(self, mesh: Mesh, material: np.ndarray, at=(0, 0, 0), turn: float = 0.0):
        """Add a solid, turned about its own vertical axis and then moved."""
        self.meshes.append(mesh.placed(at, turn))
        self.materials.append(material)

    def box(self, size, at, material, turn=0.0):
        """Add a box standing on `at` (its bottom's centre)."""
        at = np.asarray(at, float) + [0, 0, size[2] / 2]
        self.add(meshes.box(size), material, at, turn)

    def cylinder(self, radius, height, at, material):
        """Add a cylinder standing on `at`."""
        middle = np.asarray(at, float) + [0, 0, height / 2]
        self.add(meshes.cylinder(radius, height), material, middle)

    def blob(self, size, at, material):
        """Add an ellipsoid centred on `at`."""
        self.add(meshes.sphere(2).scaled(size), material, at, self.rng.uniform(0, np.pi))

    def lathe(self, profile, at, material):
        """Add a turned solid from (radius, height) pairs, standing on `at`."""
        self.add(meshes.lathe(profile, sections=32), material, at)

    def material(self, kind: int, scale: float, tint: Tint, gloss: float = 0.0, accent=0.05):
        """A material near a tint: a darker relative, and a third colour `accent` away in hue."""
        rng = self.rng
        hue = tint[0] + rng.normal(0, 0.012)
        saturation = tint[1] * rng.uniform(0.8, 1.2)
        value = min(tint[2] * rng.uniform(0.88, 1.12), 0.95)
        dark = value < 0.65
        contrast = rng.uniform(1.2, 1.5) if dark else rng.uniform(0.5, 0.7)
        first = hsv(hue, saturation, value)
        second = hsv(hue + rng.normal(0, 0.02), saturation, value * rng.uniform(0.5, 0.72))
        paler = saturation * (0.5 if dark else 0.9)
        third = hsv(hue + rng.normal(0, accent), paler, min(value * contrast, 0.95))
        # tints are as displayed; the sensor squares them back
        first, second, third = np.square(first), np.square(second), np.square(third)
        return tx.material(kind, first, second, third, scale, int(rng.integers(1, 10_000)), gloss)

    def pick(self, choices):
        """Return one of the choices."""
        return choices[int(self.rng.integers(len(choices)))]

    def finish(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return triangles (n, 3, 3) float32, their materials (n,) int32 and objects (n,) uint8, 0
        for none, and the table of materials."""
        numbers = np.zeros(len(self.meshes), np.uint8)
        for number, rows in self.objects.items():
            numbers[rows] = number
        triangles = np.concatenate([m.triangles for m in self.meshes]).astype(np.float32)
        owner = np.repeat(np.arange(len(self.meshes)), [len(m.faces) for m in self.meshes])
        return triangles, owner.astype(np.int32), numbers[owner], np.array(self.materials)


def hsv(hue: float, saturation: float, value: float) -> np.ndarray:
    """Return RGB in 0..1; the hue wraps."""
    k = (np.array([5, 3, 1]) + 6 * (hue % 1)) % 6
    return value - value * saturation * np.clip(np.minimum(k, 4 - k), 0, 1)


def clutter(scene: Scene, base) -> None:
    """Add a few small things on a surface: boxes, vases, bowls."""
    rng = scene.rng
    for _ in range(int(rng.integers(2, 5))):
        spot = base + [rng.uniform(-0.3, 0.3), rng.uniform(-0.12, 0.12), 0]
        tint = scene.pick(CLOTHS + (TERRACOTTA, SLATE, WOOD))
        if rng.random() < 0.4:
            size = rng.uniform(0.1, 0.25, 3)
            kind = scene.pick((tx.POSTER, tx.BOOKS, tx.RUG))
            scene.box(size, spot, scene.material(kind, 0.1, tint, accent=0.12), rng.uniform(0, 3))
        else:
            r = rng.uniform(0.05, 0.11)
            profile = [(0, 0), (r, 0), (r * 1.3, r), (r * 1.35, r * 1.8), (r * 0.6, r * 2.8)]
            profile += [(r * 0.75, r * 3.1), (0, r * 3.1)]
            kind = scene.pick((tx.STRIPE, tx.MARBLE, tx.RUG))
            scene.lathe(profile, spot, scene.material(kind, 0.07, tint, gloss=0.3))


def plant(scene: Scene, base) -> None:
    """Add a pot of leaves."""
    pot = scene.material(tx.NOISE, 0.1, TERRACOTTA)
    scene.lathe([(0, 0), (0.14, 0), (0.2, 0.32), (0.16, 0.35), (0, 0.35)], base, pot)
    stem = scene.material(tx.PLANK, 0.1, WOOD)
    scene.cylinder(0.02, 0.5, base + [0, 0, 0.2], stem)
    for _ in range(9):
        leaves = scene.material(tx.LEAVES, 0.12, FOLIAGE)
        offset = scene.rng.uniform(-1, 1, 3) * [0.16, 0.16, 0.22] + [0, 0, 0.62]
        scene.blob(scene.rng.uniform(0.06, 0.19, 3), base + offset, leaves)
