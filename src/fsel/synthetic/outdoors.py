"""Squares and gardens under a sky, z up, metres."""

from __future__ import annotations

import numpy as np

from fsel.synthetic import meshes, solids
from fsel.synthetic import textures as tx
from fsel.synthetic.solids import Scene


def outdoor(rng: np.random.Generator, ring: float, buildings: int, trees: int) -> Scene:
    """Open ground with a path, houses and trees on a ring of the given radius, hills beyond."""
    sun = np.array([rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.8, 1.6)])
    scene = Scene(rng, sun / np.linalg.norm(sun), 0.5, outdoor=True)
    scene.box((160, 160, 0.2), (0, 0, -0.2), scene.material(tx.LEAVES, 0.7, solids.GRASS))
    paving = scene.material(tx.TILE, 0.5, solids.STONE)
    scene.box((1.7 * ring, 1.5, 0.06), (0, 0, -0.04), paving, rng.uniform(0, 3))
    square = scene.material(tx.COBBLE, 0.55, scene.pick((solids.STONE, solids.SLATE)))
    scene.cylinder(ring * 0.55, 0.05, (0, 0, -0.04), square)
    start = rng.uniform(0, 2 * np.pi)
    for i in range(buildings):
        angle = start + 2 * np.pi * i / buildings + rng.normal(0, 0.12)
        distance = ring * rng.uniform(1.25, 1.6)
        _house(scene, (distance * np.cos(angle), distance * np.sin(angle)), angle)
    for _ in range(trees):
        _tree(scene, _somewhere(rng, 1.15 * ring, 2.2 * ring), rng.uniform(1.6, 3.2))
        _bush(scene, _somewhere(rng, 0.85 * ring, 1.5 * ring), rng.uniform(0.25, 0.6))
    for _ in range(12):
        size = (rng.uniform(12, 22), rng.uniform(12, 22), rng.uniform(4, 11))
        scene.blob(size, _somewhere(rng, 52, 75), scene.material(tx.LEAVES, 3.0, solids.FOLIAGE))
    return scene


def _somewhere(rng, near: float, far: float) -> np.ndarray:
    """(3,) a spot on the ground at a distance from the origin."""
    angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(near, far)
    return np.array([distance * np.cos(angle), distance * np.sin(angle), 0.0])


def _house(scene: Scene, at, turn: float) -> None:
    """A house with a gable that faces the origin."""
    rng = scene.rng
    width, depth, height = rng.uniform(4, 7), rng.uniform(3, 5), rng.uniform(3, 6.5)
    kind = scene.pick((tx.BRICK, tx.BRICK, tx.PLANK, tx.NOISE, tx.COBBLE))
    paint = scene.pick(solids.PAINTS)
    tint = {tx.BRICK: solids.BRICKWORK, tx.COBBLE: solids.STONE}.get(kind, paint)
    wall = scene.material(kind, 0.5 if kind != tx.PLANK else 0.3, tint)
    base = np.array([*at, 0.0])
    scene.box((depth, width, height), base, wall, turn)
    tiles = scene.material(tx.BRICK, 0.5, scene.pick((solids.TERRACOTTA, solids.SLATE)))
    pitch = rng.uniform(0.9, 1.6)
    roof = meshes.gable((depth * 1.2, width * 1.1, pitch))
    scene.add(roof, tiles, base + [0, 0, height], turn)
    front = -np.array([np.cos(turn), np.sin(turn), 0]) * depth / 2
    side = np.array([-np.sin(turn), np.cos(turn), 0])
    glass = scene.material(tx.NOISE, 0.5, solids.GLASS, gloss=0.5)
    frame = scene.material(tx.PLAIN, 1.0, solids.PLASTER)
    for level in np.arange(1.0, height - 1.0, 1.7):
        for s in np.linspace(-0.36, 0.36, 3) * width:
            spot = base + front + side * s + [0, 0, level]
            scene.box((0.16, 1.0, 1.15), spot - [0, 0, 0.07], frame, turn)
            scene.box((0.24, 0.8, 1.0), spot, glass, turn)
    scene.box((0.3, 0.9, 1.9), base + front, scene.material(tx.PLANK, 0.2, solids.WOOD), turn)


def _tree(scene: Scene, base: np.ndarray, height: float) -> None:
    trunk = scene.material(tx.PLANK, 0.12, solids.WOOD)
    scene.cylinder(0.13, height * 0.7, base, trunk)
    leaves = scene.material(tx.LEAVES, 0.5, solids.FOLIAGE)
    for _ in range(11):
        offset = scene.rng.uniform(-0.33, 0.33, 3) * height * [1, 1, 0.8] + [0, 0, height * 0.9]
        scene.blob(scene.rng.uniform(0.13, 0.27, 3) * height, base + offset, leaves)


def _bush(scene: Scene, base: np.ndarray, size: float) -> None:
    leaves = scene.material(tx.LEAVES, 0.3, solids.FOLIAGE)
    for _ in range(4):
        offset = scene.rng.normal(0, 0.5 * size, 3) * [1, 1, 0.1] + [0, 0, 0.4 * size]
        scene.blob(scene.rng.uniform(0.5, 1.0, 3) * size, base + offset, leaves)


def crates(scene: Scene, count: int) -> None:
    """Leave boxes about a square."""
    rng = scene.rng
    for _ in range(count):
        wood = scene.material(tx.PLANK, 0.2, scene.pick((solids.WOOD, solids.OAK)))
        at = _somewhere(rng, 2.6, 6.5)
        scene.box(rng.uniform(0.5, 1.3, 3), at, wood, rng.uniform(0, np.pi))


def monument(scene: Scene, size: float) -> None:
    """Add a large object at the origin: steps, a pedestal, a turned figure, and urns on pillars."""
    rng = scene.rng
    for step in range(3):
        side = size * (0.75 - 0.13 * step)
        stone = scene.material(tx.BRICK, 0.35, solids.STONE)
        scene.box((side, side, 0.22), (0, 0, 0.22 * step), stone)
    pedestal = scene.material(tx.COBBLE, 0.16, scene.pick((solids.STONE, solids.BRICKWORK)))
    scene.box((0.3 * size, 0.3 * size, 0.5 * size), (0, 0, 0.66), pedestal)
    top = 0.66 + 0.5 * size
    slab = scene.material(tx.TILE, 0.2, solids.STONE)
    scene.box((0.36 * size, 0.36 * size, 0.06), (0, 0, top), slab)
    figure = scene.material(tx.MARBLE, 0.2, scene.pick((solids.MARBLE, solids.BRONZE)), gloss=0.3)
    r = 0.14 * size
    profile = [(0, 0), (r, 0), (r * 0.95, 0.5 * r), (r * 0.6, r), (r * 0.75, 1.5 * r)]
    profile += [(r * 1.1, 2.1 * r), (r * 0.95, 2.6 * r), (r * 0.35, 3.0 * r), (0, 3.1 * r)]
    scene.lathe(profile, (0, 0, top + 0.06), figure)
    scene.blob((r * 0.5, r * 0.5, r * 0.65), (0, 0, top + 3.6 * r), figure)
    for i in range(4):
        angle = rng.uniform(0, 0.5) + i * np.pi / 2
        _urn(scene, np.array([np.cos(angle), np.sin(angle), 0]) * size * 0.42, size)


def _urn(scene: Scene, at: np.ndarray, size: float) -> None:
    """A planted urn on a brick pillar."""
    height, s = scene.rng.uniform(0.3, 0.6) * size, 0.1 * size
    scene.cylinder(0.8 * s, height, at, scene.material(tx.BRICK, 0.2, solids.BRICKWORK))
    profile = [(0, 0), (0.5 * s, 0), (0.4 * s, 0.4 * s), (s, 1.2 * s), (1.1 * s, 1.7 * s)]
    profile += [(0, 1.7 * s)]
    stone = scene.material(tx.MARBLE, 0.12, scene.pick((solids.STONE, solids.TERRACOTTA)))
    scene.lathe(profile, at + [0, 0, height], stone)
    leaves = scene.material(tx.LEAVES, 0.1, solids.FOLIAGE)
    scene.blob((s, s, s), at + [0, 0, height + 1.9 * s], leaves)


def block(scene: Scene, height: float) -> None:
    """Add a stone block at the origin to put a thing on."""
    stone = scene.material(tx.COBBLE, 0.16, scene.pick((solids.STONE, solids.BRICKWORK)))
    turn = scene.rng.uniform(0, np.pi)
    scene.box((0.85, 0.85, height - 0.06), (0, 0, 0), stone, turn)
    slab = scene.material(tx.TILE, 0.24, scene.pick((solids.STONE, solids.TERRACOTTA)))
    scene.box((0.98, 0.98, 0.06), (0, 0, height - 0.06), slab, turn)


def still_life(scene: Scene) -> None:
    """Add a garden table with things on it, at the origin, and low walls and pots around."""
    rng = scene.rng
    scene.cylinder(0.3, 0.62, (0, 0, 0), scene.material(tx.BRICK, 0.2, solids.BRICKWORK))
    wood = scene.material(tx.PLANK, 0.12, scene.pick((solids.WOOD, solids.OAK)), gloss=0.2)
    scene.cylinder(0.85, 0.08, (0, 0, 0.62), wood)
    for _ in range(7):
        angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(0, 0.55)
        at = np.array([distance * np.cos(angle), distance * np.sin(angle), 0.7])
        solids.clutter(scene, at)
    solids.plant(scene, np.array([0.0, 0.0, 0.7]))
    for i in range(5):
        angle = rng.uniform(0, 0.8) + i * 1.25
        at = np.array([np.cos(angle), np.sin(angle), 0]) * rng.uniform(3.6, 5.0)
        wall = scene.material(tx.COBBLE, 0.2, solids.STONE)
        height = rng.uniform(0.4, 0.8)
        scene.box((0.4, rng.uniform(0.8, 1.8), height), at, wall, angle)
        solids.plant(scene, at + [0, 0, height])
