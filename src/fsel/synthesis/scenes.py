"""Places to film: rooms and outdoor scenes assembled from solids, z up, metres."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import trimesh

from fsel.synthesis import textures as tx


@dataclass
class Scene:
    """A growing list of solids; `finish` makes the arrays that the ray caster wants.

    Attributes:
        rng: the only source of chance.
        sun: (3,) direction towards the light.
        ambient: light that reaches every surface.
        outdoor: whether rays that hit nothing see a sky.
    """

    rng: np.random.Generator
    sun: np.ndarray
    ambient: float
    outdoor: bool
    meshes: list[trimesh.Trimesh] = field(default_factory=list)
    materials: list[np.ndarray] = field(default_factory=list)
    owner: list[int] = field(default_factory=list)

    def add(self, mesh: trimesh.Trimesh, material: np.ndarray, at=(0, 0, 0), turn: float = 0.0):
        """Add a solid, turned about its own vertical axis and then moved."""
        mesh = mesh.copy()
        mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
        mesh.apply_translation(at)
        self.meshes.append(mesh)
        self.owner.append(len(self.materials))
        self.materials.append(material)

    def box(self, size, at, material, turn=0.0):
        """A box standing on `at` (its bottom's centre)."""
        at = np.asarray(at, float) + [0, 0, size[2] / 2]
        self.add(trimesh.creation.box(extents=size), material, at, turn)

    def cylinder(self, radius, height, at, material):
        """A cylinder standing on `at`."""
        mesh = trimesh.creation.cylinder(radius=radius, height=height, sections=18)
        self.add(mesh, material, np.asarray(at, float) + [0, 0, height / 2])

    def blob(self, size, at, material):
        """An ellipsoid centred on `at`."""
        mesh = trimesh.creation.icosphere(2)
        mesh.apply_scale(size)
        self.add(mesh, material, at, self.rng.uniform(0, np.pi))

    def lathe(self, profile, at, material):
        """A turned solid from (radius, height) pairs, standing on `at`."""
        self.add(trimesh.creation.revolve(np.asarray(profile, float), sections=20), material, at)

    def material(self, kind: int, scale: float, hue: float | None = None, gloss: float = 0.0):
        """A random material of a kind: a hue, a lighter and darker relative, and an accent."""
        rng = self.rng
        hue = rng.random() if hue is None else hue
        saturation, value = rng.uniform(0.25, 0.7), rng.uniform(0.45, 0.9)
        first = hsv(hue, saturation, value)
        second = hsv(hue + rng.normal(0, 0.06), saturation * 0.8, value * rng.uniform(0.4, 0.75))
        third = hsv(hue + rng.uniform(0.3, 0.7), rng.uniform(0.2, 0.8), rng.uniform(0.5, 1.0))
        seed = int(rng.integers(1, 10_000))
        return tx.material(kind, first, second, third, scale, seed, gloss)

    def finish(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles (n, 3, 3) float32, their material (n,) int32, the material table."""
        triangles = np.concatenate([m.triangles for m in self.meshes]).astype(np.float32)
        counts = [len(m.faces) for m in self.meshes]
        return triangles, np.repeat(self.owner, counts).astype(np.int32), np.array(self.materials)


def hsv(hue: float, saturation: float, value: float) -> np.ndarray:
    """RGB in 0..1; the hue wraps."""
    k = (np.array([5, 3, 1]) + 6 * (hue % 1)) % 6
    return value - value * saturation * np.clip(np.minimum(k, 4 - k), 0, 1)


def room(rng: np.random.Generator, width: float, depth: float, clutter: int) -> Scene:
    """A furnished room, `width` x `depth` x 2.8 m, its middle at the origin, its ring walkable."""
    light = np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), 1.0])
    scene = Scene(rng, light / np.linalg.norm(light), 0.62, outdoor=False)
    wood = scene.material(tx.PLANK, 0.16, hue=0.08, gloss=0.15)
    scene.box((width, depth, 0.1), (0, 0, -0.1), wood)
    scene.box((width, depth, 0.1), (0, 0, 2.8), scene.material(tx.TILE, 0.7, hue=0.12))
    kinds = rng.permutation([tx.BRICK, tx.STRIPE, tx.PLAIN, tx.NOISE])
    for side, kind in enumerate(kinds):
        across = width if side < 2 else depth
        turn = 0.0 if side < 2 else np.pi / 2
        sign = 1 if side % 2 else -1
        at = (0, sign * depth / 2, 0) if side < 2 else (sign * width / 2, 0, 0)
        wall = scene.material(int(kind), 0.28 if kind == tx.BRICK else 0.4)
        scene.box((across, 0.1, 2.8), at, wall, turn)
        _along_wall(scene, at, across, turn, sign)
    scene.box((width * 0.45, depth * 0.45, 0.02), (0, 0, 0), scene.material(tx.POSTER, 0.35))
    _table(scene, (rng.normal(0, 0.15), rng.normal(0, 0.15)))
    for _ in range(clutter):
        angle, radius = rng.uniform(0, 2 * np.pi), rng.uniform(0.6, 1.1)
        _seat(scene, (radius * np.cos(angle), radius * np.sin(angle)), angle)
    return scene


def _along_wall(scene: Scene, at, across: float, turn: float, sign: int) -> None:
    """Furniture and pictures against one wall."""
    rng = scene.rng
    tangent = np.array([np.cos(turn), np.sin(turn), 0])
    inward = -sign * np.array([-np.sin(turn), np.cos(turn), 0]) * (1 if turn == 0 else -1)
    at = np.asarray(at, float)
    for place in np.linspace(-0.34, 0.34, 3) * across:
        base = at + tangent * (place + rng.normal(0, 0.1)) + inward * 0.28
        choice = rng.integers(4)
        if choice == 0:
            _shelf(scene, base, turn)
        elif choice == 1:
            height = rng.uniform(0.6, 1.1)
            kind = int(rng.choice([tx.PLANK, tx.NOISE, tx.TILE]))
            scene.box((1.0, 0.4, height), base, scene.material(kind, 0.2, gloss=0.3), turn)
            _clutter(scene, base + [0, 0, height])
        elif choice == 2:
            _plant(scene, base)
        picture = at + tangent * (place + rng.normal(0, 0.15)) + inward * 0.07
        size = (rng.uniform(0.5, 1.0), 0.04, rng.uniform(0.4, 0.7))
        scene.box(size, picture + [0, 0, 1.45], scene.material(tx.POSTER, 0.18, gloss=0.2), turn)


def _shelf(scene: Scene, base, turn: float) -> None:
    frame = scene.material(tx.PLANK, 0.15, hue=0.07)
    for level in range(4):
        scene.box((1.0, 0.36, 0.04), base + [0, 0, 0.45 * level], frame, turn)
        if level < 3:
            books = scene.material(tx.BOOKS, 0.2)
            height = scene.rng.uniform(0.24, 0.36)
            books_size = (0.9, 0.22, height)
            scene.box(books_size, base + [0, 0, 0.45 * level + 0.04], books, turn)


def _plant(scene: Scene, base) -> None:
    pot = scene.material(tx.NOISE, 0.2, hue=0.05)
    scene.lathe([(0, 0), (0.16, 0), (0.22, 0.35), (0, 0.35)], base, pot)
    leaves = scene.material(tx.LEAVES, 0.16, hue=0.3)
    for _ in range(5):
        offset = scene.rng.normal(0, 0.12, 3) + [0, 0, 0.8]
        scene.blob(scene.rng.uniform(0.12, 0.26, 3), base + offset, leaves)


def _clutter(scene: Scene, base) -> None:
    rng = scene.rng
    for _ in range(int(rng.integers(2, 5))):
        spot = base + [rng.uniform(-0.3, 0.3), rng.uniform(-0.12, 0.12), 0]
        if rng.random() < 0.5:
            size = rng.uniform(0.1, 0.25, 3)
            scene.box(size, spot, scene.material(tx.POSTER, 0.1), rng.uniform(0, 3))
        else:
            r = rng.uniform(0.05, 0.11)
            profile = [(0, 0), (r, 0), (r * 1.3, r * 2), (r * 0.6, r * 3), (0, r * 3)]
            scene.lathe(profile, spot, scene.material(tx.STRIPE, 0.08, gloss=0.4))


def _table(scene: Scene, at) -> None:
    wood = scene.material(tx.PLANK, 0.14, hue=0.09, gloss=0.3)
    base = np.array([*at, 0.0])
    for dx in (-0.6, 0.6):
        for dy in (-0.35, 0.35):
            scene.box((0.06, 0.06, 0.7), base + [dx, dy, 0], wood)
    scene.box((1.4, 0.9, 0.05), base + [0, 0, 0.7], wood)
    for dx in (-0.4, 0.0, 0.4):
        _clutter(scene, base + [dx, 0, 0.75])


def _seat(scene: Scene, at, turn: float) -> None:
    cloth = scene.material(int(scene.rng.choice([tx.STRIPE, tx.NOISE, tx.TILE])), 0.15)
    base = np.array([*at, 0.0])
    scene.box((0.42, 0.42, 0.45), base, cloth, turn)
    back = base + 0.2 * np.array([np.cos(turn), np.sin(turn), 0])
    scene.box((0.06, 0.42, 0.9), back, cloth, turn)


def outdoor(rng: np.random.Generator, ring: float, buildings: int, trees: int) -> Scene:
    """Open ground with a path, houses and trees on a ring of the given radius."""
    sun = np.array([rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.8, 1.6)])
    scene = Scene(rng, sun / np.linalg.norm(sun), 0.5, outdoor=True)
    scene.box((160, 160, 0.2), (0, 0, -0.2), scene.material(tx.NOISE, 0.8, hue=0.27))
    paving = scene.material(tx.TILE, 0.6, hue=0.1)
    scene.box((1.7 * ring, 1.5, 0.06), (0, 0, -0.04), paving, rng.uniform(0, 3))
    scene.cylinder(ring * 0.55, 0.05, (0, 0, -0.04), scene.material(tx.POSTER, 0.9, hue=0.09))
    start = rng.uniform(0, 2 * np.pi)
    for i in range(buildings):
        angle = start + 2 * np.pi * i / buildings + rng.normal(0, 0.12)
        distance = ring * rng.uniform(1.25, 1.6)
        _house(scene, (distance * np.cos(angle), distance * np.sin(angle)), angle)
    for _ in range(trees):
        angle, distance = rng.uniform(0, 2 * np.pi), ring * rng.uniform(1.15, 2.2)
        _tree(scene, (distance * np.cos(angle), distance * np.sin(angle)), rng.uniform(1.6, 3.2))
    return scene


def _house(scene: Scene, at, turn: float) -> None:
    rng = scene.rng
    width, depth, height = rng.uniform(4, 7), rng.uniform(3, 5), rng.uniform(3, 6.5)
    kind = int(rng.choice([tx.BRICK, tx.BRICK, tx.PLANK, tx.NOISE]))
    wall = scene.material(kind, 0.5 if kind != tx.PLANK else 0.3)
    base = np.array([*at, 0.0])
    scene.box((depth, width, height), base, wall, turn)
    scene.box(
        (depth * 1.12, width * 1.12, 0.35), base + [0, 0, height], scene.material(tx.TILE, 0.4)
    )
    front = -np.array([np.cos(turn), np.sin(turn), 0]) * depth / 2
    side = np.array([-np.sin(turn), np.cos(turn), 0])
    glass = scene.material(tx.POSTER, 0.5, hue=0.58, gloss=0.5)
    frame = scene.material(tx.PLAIN, 1.0, hue=0.12)
    for level in np.arange(1.0, height - 1.0, 1.7):
        for s in np.linspace(-0.36, 0.36, 3) * width:
            spot = base + front + side * s + [0, 0, level]
            scene.box((0.16, 1.0, 1.15), spot - [0, 0, 0.07], frame, turn)
            scene.box((0.24, 0.8, 1.0), spot, glass, turn)
    scene.box((0.3, 0.9, 1.9), base + front, scene.material(tx.PLANK, 0.2), turn)


def _tree(scene: Scene, at, height: float) -> None:
    base = np.array([*at, 0.0])
    scene.cylinder(0.14, height * 0.6, base, scene.material(tx.PLANK, 0.12, hue=0.07))
    leaves = scene.material(tx.LEAVES, 0.5, hue=scene.rng.uniform(0.2, 0.36))
    for _ in range(6):
        offset = scene.rng.normal(0, 0.22 * height, 3) * [1, 1, 0.6] + [0, 0, height * 0.85]
        scene.blob(scene.rng.uniform(0.16, 0.34, 3) * height, base + offset, leaves)


def monument(scene: Scene, size: float) -> None:
    """A large object at the origin: steps, a pedestal, a turned figure with arms and a crown."""
    rng = scene.rng
    for step in range(3):
        side = size * (0.75 - 0.13 * step)
        stone = scene.material(tx.BRICK, 0.35, hue=0.1)
        scene.box((side, side, 0.22), (0, 0, 0.22 * step), stone)
    scene.box((0.3 * size, 0.3 * size, 0.5 * size), (0, 0, 0.66), scene.material(tx.POSTER, 0.3))
    top = 0.66 + 0.5 * size
    r = 0.14 * size
    profile = [(0, 0), (r, 0), (r * 0.6, r), (r * 1.2, 2 * r), (r * 0.5, 3.2 * r), (0, 3.6 * r)]
    scene.lathe(profile, (0, 0, top), scene.material(tx.STRIPE, 0.2, gloss=0.5))
    scene.blob((r * 0.6,) * 3, (0, 0, top + 4 * r), scene.material(tx.NOISE, 0.15, gloss=0.5))
    for i in range(4):
        angle = rng.uniform(0, 0.5) + i * np.pi / 2
        at = np.array([np.cos(angle), np.sin(angle), 0]) * size * 0.42
        scene.cylinder(0.08 * size, rng.uniform(0.3, 0.6) * size, at, scene.material(tx.TILE, 0.2))
        scene.blob((0.11 * size,) * 3, at + [0, 0, 0.62 * size], scene.material(tx.POSTER, 0.2))


def still_life(scene: Scene) -> None:
    """A garden table with things on it, at the origin."""
    rng = scene.rng
    stone = scene.material(tx.TILE, 0.18, hue=0.1, gloss=0.3)
    scene.cylinder(0.3, 0.62, (0, 0, 0), scene.material(tx.BRICK, 0.2, hue=0.06))
    scene.cylinder(0.85, 0.08, (0, 0, 0.62), stone)
    for _ in range(7):
        angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(0, 0.55)
        _clutter(scene, np.array([distance * np.cos(angle), distance * np.sin(angle), 0.7]))
    _plant(scene, np.array([0.0, 0.0, 0.7]))
    for i in range(5):
        angle = rng.uniform(0, 0.8) + i * 1.25
        at = np.array([np.cos(angle), np.sin(angle), 0]) * rng.uniform(3.6, 5.0)
        scene.box(rng.uniform(0.4, 0.9, 3), at, scene.material(tx.PLANK, 0.18), angle)
