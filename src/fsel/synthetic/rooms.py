"""Furnished rooms, z up, metres."""

from __future__ import annotations

import numpy as np

from fsel.captures.layouts.contract import SUBJECT
from fsel.synthetic import solids, things
from fsel.synthetic import textures as tx
from fsel.synthetic.solids import Scene

HEIGHT = 2.8
LAMP = 2.5  # metres above the floor


def room(rng: np.random.Generator, width: float, depth: float, seats: int) -> Scene:
    """A furnished room, `width` x `depth` x 2.8 m, its middle at the origin, its ring walkable."""
    scene = shell(rng, width, depth)
    _table(scene, (rng.normal(0, 0.15), rng.normal(0, 0.15)))
    for _ in range(seats):
        angle, radius = rng.uniform(0, 2 * np.pi), rng.uniform(0.6, 1.1)
        _seat(scene, (radius * np.cos(angle), radius * np.sin(angle)), angle)
    return scene


def shell(rng: np.random.Generator, width: float, depth: float) -> Scene:
    """Make floor, ceiling, a rug, and walls with what stands against them; its middle is free."""
    lamp = np.array([rng.uniform(-0.8, 0.8), rng.uniform(-0.8, 0.8), LAMP])
    scene = Scene(rng, lamp, 0.62, outdoor=False)
    floor = scene.material(tx.PLANK, 0.16, scene.pick((solids.WOOD, solids.OAK)), gloss=0.15)
    scene.box((width, depth, 0.1), (0, 0, -0.1), floor)
    ceiling = scene.material(tx.TILE, 0.6, solids.PLASTER)
    scene.box((width, depth, 0.1), (0, 0, HEIGHT), ceiling)
    for side in range(4):
        _wall(scene, side, width, depth)
    rug = scene.material(tx.RUG, 0.3, scene.pick(solids.CLOTHS), accent=0.08)
    scene.box((width * 0.45, depth * 0.45, 0.02), (0, 0, 0), rug)
    return scene


def living_room(rng: np.random.Generator, width: float, depth: float) -> Scene:
    """Make a cluttered room; its subject is one large thing near a wall, which faces the middle."""
    scene = shell(rng, width, depth)
    with scene.as_object(SUBJECT + 1):
        _table(scene, (rng.normal(0, 0.15), rng.normal(0, 0.1)))
    for seat in range(2):
        angle = rng.uniform(0, 2 * np.pi)
        with scene.as_object(SUBJECT + 2 + seat):
            _seat(scene, (0.95 * np.cos(angle), 0.8 * np.sin(angle)), angle)
    side = scene.pick((-1, 1))
    at = (rng.uniform(-0.25, 0.25) * width, side * (depth / 2 - 0.95), 0)
    turn = (0.0 if side > 0 else np.pi) + rng.normal(0, 0.25)
    with scene.as_object(SUBJECT):
        scene.pick(things.LARGE)(scene, at, turn)
    return scene


def pedestal(scene: Scene, height: float) -> None:
    """Add a round table at the origin, its top at a height, a cloth on it."""
    wood = scene.material(tx.PLANK, 0.12, scene.pick((solids.WOOD, solids.OAK)), gloss=0.2)
    scene.cylinder(0.3, 0.03, (0, 0, 0.02), wood)
    scene.cylinder(0.07, height - 0.05, (0, 0, 0.02), wood)
    scene.cylinder(0.6, 0.04, (0, 0, height - 0.04), wood)
    cloth = scene.material(tx.RUG, 0.12, scene.pick(solids.CLOTHS), accent=0.1)
    scene.box((0.62, 0.62, 0.006), (0, 0, height), cloth, scene.rng.uniform(0, 1.5))


def _wall(scene: Scene, side: int, width: float, depth: float) -> None:
    """One of four walls with a skirting board, and what stands and hangs before it."""
    across = width if side < 2 else depth
    turn = 0.0 if side < 2 else np.pi / 2
    sign = 1 if side % 2 else -1
    outward = np.array([0, sign, 0]) if side < 2 else np.array([sign, 0, 0])
    at = outward * (depth if side < 2 else width) / 2
    kind = scene.pick((tx.BRICK, tx.STRIPE, tx.PLAIN, tx.NOISE, tx.RUG))
    tint = solids.BRICKWORK if kind == tx.BRICK else scene.pick(solids.PAINTS)
    scale = {tx.BRICK: 0.28, tx.STRIPE: 0.3, tx.RUG: 0.25}.get(kind, 0.5)
    scene.box((across, 0.1, HEIGHT), at, scene.material(kind, scale, tint, accent=0.02), turn)
    skirting = scene.material(tx.PLANK, 0.1, solids.WOOD)
    scene.box((across, 0.14, 0.12), at, skirting, turn)
    _along_wall(scene, at, across, turn, -outward)


def _along_wall(scene: Scene, at, across: float, turn: float, inward: np.ndarray) -> None:
    """Furniture and pictures against one wall."""
    rng = scene.rng
    tangent = np.array([np.cos(turn), np.sin(turn), 0])
    for place in np.linspace(-0.34, 0.34, 3) * across:
        base = at + tangent * (place + rng.normal(0, 0.1)) + inward * 0.28
        choice = rng.integers(4)
        if choice == 0:
            _shelf(scene, base, turn)
        elif choice == 1:
            height = rng.uniform(0.6, 1.1)
            kind = scene.pick((tx.PLANK, tx.PLANK, tx.NOISE))
            wood = scene.material(kind, 0.2, scene.pick((solids.WOOD, solids.OAK)), gloss=0.2)
            scene.box((1.0, 0.4, height), base, wood, turn)
            solids.clutter(scene, base + [0, 0, height])
        elif choice == 2:
            solids.plant(scene, base)
        _picture(scene, at + tangent * (place + rng.normal(0, 0.15)) + inward * 0.07, turn)


def _picture(scene: Scene, at, turn: float) -> None:
    """A framed picture at eye height."""
    width, height = scene.rng.uniform(0.5, 1.0), scene.rng.uniform(0.4, 0.7)
    frame = scene.material(tx.PLANK, 0.1, scene.pick((solids.WOOD, solids.SLATE)))
    scene.box((width + 0.1, 0.03, height + 0.1), at + [0, 0, 1.4], frame, turn)
    kind = scene.pick((tx.POSTER, tx.NOISE, tx.MARBLE, tx.LEAVES))
    canvas = scene.material(kind, 0.17, scene.pick(solids.CLOTHS), gloss=0.1, accent=0.1)
    scene.box((width, 0.05, height), at + [0, 0, 1.45], canvas, turn)


def _shelf(scene: Scene, base, turn: float) -> None:
    """Four boards with books, and a back."""
    frame = scene.material(tx.PLANK, 0.15, solids.WOOD)
    tangent = np.array([np.cos(turn), np.sin(turn), 0])
    for side in (-0.5, 0.5):
        scene.box((0.05, 0.36, 1.9), base + side * tangent, frame, turn)
    for level in range(4):
        at = base + [0, 0, 0.45 * level]
        scene.box((1.0, 0.36, 0.04), at, frame, turn)
        books = scene.material(tx.BOOKS, 0.2, scene.pick(solids.CLOTHS), accent=0.06)
        height = scene.rng.uniform(0.24, 0.36)
        scene.box((0.9, 0.22, height), at + [0, 0, 0.04], books, turn)


def _table(scene: Scene, at) -> None:
    """A table with three heaps of small things."""
    wood = scene.material(tx.PLANK, 0.14, scene.pick((solids.WOOD, solids.OAK)), gloss=0.3)
    base = np.array([*at, 0.0])
    for dx in (-0.6, 0.6):
        for dy in (-0.35, 0.35):
            scene.box((0.06, 0.06, 0.7), base + [dx, dy, 0], wood)
    scene.box((1.4, 0.9, 0.05), base + [0, 0, 0.7], wood)
    for dx in (-0.4, 0.0, 0.4):
        solids.clutter(scene, base + [dx, 0, 0.75])


def _seat(scene: Scene, at, turn: float) -> None:
    """An upholstered chair that faces the middle."""
    kind = scene.pick((tx.STRIPE, tx.NOISE, tx.RUG))
    cloth = scene.material(kind, 0.15, scene.pick(solids.CLOTHS))
    base = np.array([*at, 0.0])
    scene.box((0.42, 0.42, 0.45), base, cloth, turn)
    back = base + 0.2 * np.array([np.cos(turn), np.sin(turn), 0])
    scene.box((0.06, 0.42, 0.9), back, cloth, turn)
