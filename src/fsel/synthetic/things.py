"""Single objects that a capture is about, z up, metres; each stands on its `at`."""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.synthetic import meshes, solids
from fsel.synthetic import textures as tx
from fsel.synthetic.solids import Scene

FUR = ((0.075, 0.5, 0.62), (0.06, 0.35, 0.42), (0.1, 0.25, 0.8))
TOYS = ((0.0, 0.72, 0.78), (0.58, 0.62, 0.66), (0.13, 0.75, 0.85), (0.36, 0.5, 0.55))
PETALS = ((0.95, 0.5, 0.82), (0.13, 0.65, 0.9), (0.78, 0.35, 0.75), (0.02, 0.6, 0.85))
LEATHER = ((0.05, 0.5, 0.42), (0.6, 0.3, 0.38), (0.99, 0.5, 0.5))
BLACK = (0.6, 0.1, 0.12)


class Bench:
    """Parts of one object of a scene, given in its own frame: x to its right, y to its back."""

    def __init__(self, scene: Scene, at, turn: float) -> None:
        self.scene, self.turn = scene, turn
        self.at = np.asarray(at, float)

    def place(self, x: float, y: float, z: float) -> np.ndarray:
        """Return (3,) a point of the object in the scene."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        return self.at + [c * x - s * y, s * x + c * y, z]

    def box(self, size, where, material) -> None:
        """Add a box standing on `where`."""
        self.scene.box(size, self.place(*where), material, self.turn)

    def ball(self, radii, where, material) -> None:
        """Add an ellipsoid centred on `where`."""
        self.scene.add(meshes.sphere(3).scaled(radii), material, self.place(*where), self.turn)

    def wheel(self, radius: float, width: float, where, material) -> None:
        """Add a cylinder whose axis is the object's x, centred on `where`."""
        lying = meshes.cylinder(radius, width).lying()
        self.scene.add(lying, material, self.place(*where), self.turn)


def teddy(scene: Scene, at, turn: float) -> None:
    """Add a sitting bear, half a metre high."""
    bench, fur = Bench(scene, at, turn), scene.pick(FUR)
    brown = scene.material(tx.NOISE, 0.03, fur)
    pale = scene.material(tx.NOISE, 0.03, (fur[0], fur[1] * 0.5, min(fur[2] * 1.35, 0.9)))
    black = scene.material(tx.PLAIN, 0.1, BLACK, gloss=0.4)
    ribbon = scene.material(tx.STRIPE, 0.03, scene.pick(TOYS), accent=0.2)
    bench.ball((0.14, 0.12, 0.16), (0, 0, 0.16), brown)
    bench.ball((0.1, 0.05, 0.11), (0, -0.085, 0.16), pale)
    bench.ball((0.115, 0.105, 0.1), (0, 0, 0.4), brown)
    bench.ball((0.055, 0.05, 0.042), (0, -0.09, 0.375), pale)
    bench.ball((0.018, 0.015, 0.014), (0, -0.138, 0.39), black)
    bench.wheel(0.035, 0.17, (0, -0.06, 0.31), ribbon)
    for side in (-1, 1):
        bench.ball((0.014, 0.012, 0.016), (side * 0.042, -0.094, 0.425), black)
        bench.ball((0.045, 0.022, 0.045), (side * 0.09, 0.01, 0.485), brown)
        bench.ball((0.026, 0.01, 0.026), (side * 0.09, -0.012, 0.485), pale)
        bench.ball((0.05, 0.06, 0.1), (side * 0.155, -0.03, 0.22), brown)
        bench.ball((0.062, 0.13, 0.06), (side * 0.11, -0.15, 0.06), brown)
        bench.ball((0.045, 0.014, 0.045), (side * 0.115, -0.274, 0.065), pale)


def truck(scene: Scene, at, turn: float) -> None:
    """Add a toy lorry with a load."""
    bench = Bench(scene, at, turn)
    paint = scene.material(tx.PLAIN, 0.2, scene.pick(TOYS), gloss=0.5)
    bed = scene.material(tx.STRIPE, 0.08, scene.pick(TOYS), gloss=0.3, accent=0.1)
    black = scene.material(tx.PLAIN, 0.1, BLACK)
    hub = scene.material(tx.PLAIN, 0.1, (0.13, 0.6, 0.9))
    glass = scene.material(tx.NOISE, 0.1, solids.GLASS, gloss=0.5)
    lamp = scene.material(tx.PLAIN, 0.1, (0.15, 0.2, 0.95))
    bench.box((0.2, 0.54, 0.05), (0, 0, 0.07), black)
    bench.box((0.23, 0.1, 0.12), (0, -0.25, 0.12), paint)  # bonnet
    bench.box((0.23, 0.14, 0.25), (0, -0.14, 0.12), paint)  # cabin
    bench.box((0.19, 0.15, 0.1), (0, -0.142, 0.24), glass)
    bench.box((0.24, 0.09, 0.1), (0, -0.135, 0.24), glass)
    bench.box((0.2, 0.03, 0.05), (0, -0.295, 0.13), black)
    for side in (-1, 1):
        bench.ball((0.026, 0.014, 0.026), (side * 0.085, -0.3, 0.205), lamp)
        bench.box((0.025, 0.32, 0.15), (side * 0.12, 0.11, 0.13), bed)
        for y in (-0.2, 0.06, 0.19):
            bench.wheel(0.065, 0.05, (side * 0.115, y, 0.065), black)
            bench.wheel(0.034, 0.06, (side * 0.115, y, 0.065), hub)
    for y in (-0.04, 0.26):
        bench.box((0.26, 0.025, 0.15), (0, y, 0.13), bed)
    bench.box((0.24, 0.3, 0.02), (0, 0.11, 0.125), bed)
    for x, y in ((-0.06, 0.02), (0.06, 0.06), (-0.05, 0.15), (0.06, 0.19), (0, 0.1)):
        load = scene.material(tx.MARBLE, 0.05, scene.pick((solids.STONE, solids.WOOD, *TOYS)))
        bench.ball(scene.rng.uniform(0.055, 0.075, 3), (x, y, 0.25), load)


def bouquet(scene: Scene, at, turn: float) -> None:
    """Add flowers in a painted vase."""
    bench, rng = Bench(scene, at, turn), scene.rng
    kind = scene.pick((tx.RUG, tx.STRIPE, tx.POSTER))
    glaze = scene.material(kind, 0.05, scene.pick((*TOYS, solids.MARBLE)), gloss=0.4, accent=0.3)
    r = 0.075
    profile = [(0, 0), (r, 0), (1.55 * r, 1.1 * r), (1.5 * r, 1.9 * r), (0.7 * r, 3.1 * r)]
    profile += [(0.95 * r, 3.5 * r), (0, 3.5 * r)]
    scene.lathe(profile, bench.at, glaze)
    stem, heart = (scene.material(tx.PLANK, 0.05, t) for t in (solids.FOLIAGE, (0.12, 0.7, 0.8)))
    leaf = scene.material(tx.LEAVES, 0.04, solids.FOLIAGE)
    petals = [scene.material(tx.NOISE, 0.03, tint) for tint in PETALS]
    scene.cylinder(0.03, 0.16, bench.place(0, 0, 3.5 * r), stem)
    for i in range(11):
        angle, reach = 2.4 * i, 0.17 * np.sqrt((i + 0.5) / 11)
        x, y, z = reach * np.cos(angle), reach * np.sin(angle), 0.52 - 0.9 * reach
        bench.ball((0.05, 0.05, 0.03), (x, y, z + rng.uniform(-0.02, 0.02)), scene.pick(petals))
        bench.ball((0.02, 0.02, 0.02), (1.06 * x, 1.06 * y, z + 0.028), heart)
        bench.ball((0.06, 0.035, 0.035), (0.7 * x, 0.7 * y, z - 0.08), leaf)


def houseplant(scene: Scene, at, turn: float) -> None:
    """Add a pot with broad leaves."""
    bench, rng = Bench(scene, at, turn), scene.rng
    pot = scene.material(scene.pick((tx.NOISE, tx.STRIPE)), 0.06, solids.TERRACOTTA, accent=0.2)
    profile = [(0, 0), (0.09, 0), (0.13, 0.2), (0.145, 0.2), (0.145, 0.235), (0, 0.235)]
    scene.lathe(profile, bench.at, pot)
    scene.cylinder(0.125, 0.01, bench.place(0, 0, 0.23), scene.material(tx.NOISE, 0.03, LEATHER[0]))
    leaves = [scene.material(tx.STRIPE, 0.06, (h, 0.5, 0.5), accent=0.03) for h in (0.27, 0.32)]
    for i in range(14):
        angle, reach = 2.4 * i, 0.05 + 0.012 * i
        x, y = reach * np.cos(angle), reach * np.sin(angle)
        leaf = Bench(scene, bench.place(x, y, 0), angle + turn)
        height = 0.5 - 0.014 * i + rng.uniform(-0.02, 0.02)
        leaf.ball((0.085, 0.04, 0.022), (0.03, 0, height), scene.pick(leaves))
        leaf.ball((0.012, 0.012, (height - 0.22) / 2), (-0.02, 0, (height + 0.22) / 2), leaves[0])


def satchel(scene: Scene, at, turn: float) -> None:
    """Add a standing bag with a flap, pockets and a handle."""
    bench, tint = Bench(scene, at, turn), scene.pick(LEATHER)
    hide = scene.material(tx.NOISE, 0.06, tint, gloss=0.2)
    strap = scene.material(tx.PLANK, 0.03, scene.pick((solids.OAK, *TOYS)))
    brass = scene.material(tx.PLAIN, 0.1, (0.12, 0.6, 0.85), gloss=0.6)
    cloth = scene.material(tx.RUG, 0.05, scene.pick(solids.CLOTHS), accent=0.1)
    bench.box((0.42, 0.16, 0.33), (0, 0, 0), hide)
    bench.box((0.44, 0.19, 0.2), (0, 0, 0.16), cloth)
    for side in (-1, 1):
        bench.box((0.15, 0.05, 0.13), (side * 0.105, -0.1, 0.015), hide)
        bench.box((0.035, 0.21, 0.345), (side * 0.13, 0, 0.02), strap)
        bench.ball((0.026, 0.014, 0.02), (side * 0.13, -0.11, 0.19), brass)
        bench.box((0.05, 0.12, 0.14), (side * 0.225, 0, 0.02), hide)
        bench.box((0.025, 0.03, 0.1), (side * 0.08, 0, 0.36), strap)
    bench.box((0.185, 0.03, 0.025), (0, 0, 0.45), strap)


# what stands on a table, and what stands on a floor
SMALL = (teddy, truck, bouquet, houseplant, satchel)


def sofa(scene: Scene, at, turn: float, width: float) -> None:
    """Add an upholstered seat with arms, cushions and feet."""
    bench = Bench(scene, at, turn)
    kind = scene.pick((tx.STRIPE, tx.NOISE, tx.RUG))
    cloth = scene.material(kind, 0.12, scene.pick(solids.CLOTHS + FUR))
    cushion = scene.material(tx.RUG, 0.1, scene.pick(solids.CLOTHS + TOYS), accent=0.1)
    wood = scene.material(tx.PLANK, 0.1, solids.WOOD)
    inner = width - 0.26
    bench.box((width, 0.72, 0.2), (0, 0, 0.12), cloth)
    bench.box((width, 0.18, 0.74), (0, 0.3, 0.12), cloth)
    for side in (-1, 1):
        bench.box((0.14, 0.72, 0.44), (side * (width / 2 - 0.07), 0, 0.12), cloth)
        for y in (-0.3, 0.33):
            bench.box((0.06, 0.06, 0.12), (side * (width / 2 - 0.07), y, 0), wood)
    seats = max(1, round(inner / 0.6))
    for i in range(seats):
        x = inner * ((i + 0.5) / seats - 0.5)
        bench.box((inner / seats - 0.02, 0.56, 0.12), (x, -0.07, 0.32), cloth)
        bench.box((0.4, 0.12, 0.34), (x, 0.17, 0.43), cushion)


def dresser(scene: Scene, at, turn: float) -> None:
    """Add a chest of drawers with knobs, standing free."""
    bench = Bench(scene, at, turn)
    tint = scene.pick((solids.WOOD, solids.OAK, TOYS[1], TOYS[3]))
    body = scene.material(tx.PLANK, 0.12, tint, gloss=0.2)
    front = scene.material(scene.pick((tx.PLANK, tx.MARBLE)), 0.15, tint, gloss=0.2)
    knob = scene.material(tx.PLAIN, 0.1, (0.12, 0.4, 0.85), gloss=0.5)
    bench.box((0.9, 0.48, 0.86), (0, 0, 0.06), body)
    bench.box((0.98, 0.56, 0.04), (0, 0, 0.92), front)
    for level in range(3):
        bench.box((0.82, 0.06, 0.23), (0, -0.235, 0.1 + 0.27 * level), front)
        for x in (-0.22, 0.22):
            bench.ball((0.03, 0.03, 0.03), (x, -0.285, 0.215 + 0.27 * level), knob)
    for x in (-0.4, 0.4):
        for y in (-0.19, 0.19):
            bench.box((0.06, 0.06, 0.06), (x, y, 0), body)


LARGE = (partial(sofa, width=0.92), partial(sofa, width=1.35), dresser)
