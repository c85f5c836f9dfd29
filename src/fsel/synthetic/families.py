"""The families: where each dataset films, how it moves, and what its sensor does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import SUBJECT
from fsel.synthetic import outdoors, things, trajectories
from fsel.synthetic.rooms import living_room, pedestal, room, shell
from fsel.synthetic.solids import Scene
from fsel.synthetic.trajectories import Habits, Shot, plan

OUTWARD = 0.5  # share of a family's rooms that are filmed towards their walls
TABLE = 0.72  # metres from the ground to where a single object stands


@dataclass(frozen=True)
class Setting:
    """What a family films and how, and what its cameras must keep clear of."""

    scene: Callable[[np.random.Generator], Scene]
    shot: Callable[[np.random.Generator, int], Shot]  # a filming of so many frames
    clearance: float  # least distance from a camera to any surface, metres
    view: float  # least distance straight ahead, metres
    seeing: float = 0.0  # least share of the frames that see the scene's subject, if it has one
    metric: bool = False  # whether the capture's world is metric and upright


def _lens(
    model: str, focal: float, *distortion: float, stretch=1.0, middle=(0.5, 0.5)
) -> Callable[[int, int], Camera]:
    """Camera of a width and height: `focal` in widths, `stretch` of its vertical one over it."""

    def make(w: int, h: int) -> Camera:
        params = (focal * w, focal * w * stretch, w * middle[0], h * middle[1], *distortion)
        return Camera(model, w, h, params)

    return make


def _phone(focal: float, k1: float, k2: float) -> Callable[[int, int], Camera]:
    middle = (0.503, 0.497)
    return _lens("OPENCV", focal, k1, k2, 3e-4, -4e-4, stretch=1.002, middle=middle)


def _dl3dv_scene(rng) -> Scene:
    if rng.random() < 0.3:
        return room(rng, 8.0, 6.5, 3)
    scene = outdoors.outdoor(rng, 8.0, 6, 9)
    outdoors.crates(scene, 6)
    outdoors.monument(scene, 1.3)
    return scene


def _dl3dv(rng, frames: int) -> Shot:
    style = rng.integers(3)
    if style == 0:
        path = trajectories.street_walk(rng, rng.uniform(7, 10))
    elif style == 1:
        path = trajectories.orbit(rng, rng.uniform(0.7, 1.2), 3.6, (1.5, 1.8), (0, 0, 1.2))
    else:
        path = trajectories.ring_walk(rng, 2.3, 1.9, 1.5, rng.uniform(0.9, 1.5))
    habits = Habits(lingers=3, blurs=4, strength=0.05, drift=0.15, noise=0.008)
    return plan(rng, [path], frames, _phone(rng.uniform(0.75, 0.9), -0.03, 0.008), habits)


def _tanks_scene(rng) -> Scene:
    scene = outdoors.outdoor(rng, 8.5, 5, 10)
    outdoors.monument(scene, rng.uniform(2.2, 2.8))
    return scene


def _tanks(rng, frames: int) -> Shot:
    path = trajectories.orbit(rng, rng.uniform(1.0, 1.5), 4.3, (1.5, 2.3, 1.6), (0, 0, 1.3))
    habits = Habits(lingers=3, blurs=3, strength=0.04, drift=0.2, noise=0.006, lost=2)
    return plan(rng, [path], frames, _lens("PINHOLE", rng.uniform(0.75, 0.85)), habits)


def _mipnerf_scene(rng) -> Scene:
    scene = outdoors.outdoor(rng, 11.0, 4, 16)
    outdoors.still_life(scene)
    return scene


def _mipnerf(rng, frames: int) -> Shot:
    path = trajectories.orbit(rng, 2.7, 2.0, (1.1, 1.5, 2.0), (0, 0, 0.75))
    habits = Habits(lingers=2, blurs=2, strength=0.03, drift=0.05, noise=0.004, shutter=0.05)
    return plan(rng, [path], frames, _lens("PINHOLE", rng.uniform(0.8, 0.95)), habits)


def _iphone(rng, frames: int) -> Shot:
    outward = rng.random() < OUTWARD
    loops = rng.uniform(1.2, 1.8)
    path = trajectories.ring_walk(rng, 1.9, 1.5, 1.45, loops, outward=outward)
    habits = Habits(
        lingers=4, blurs=9, strength=0.09, drift=0.35, noise=0.012, shutter=0.12, lost=2
    )
    return plan(rng, [path], frames, _phone(0.78, 0.02, -0.01), habits, name="frame_{:06d}")


def _scannetpp(rng, frames: int) -> Shot:
    """Stills, further apart than frames of a video; each overlaps the next."""
    outward = rng.random() < OUTWARD
    loops = rng.uniform(2.6, 3.2)
    path = trajectories.ring_walk(rng, 2.0, 1.6, 1.5, loops, outward=outward)
    habits = Habits(
        lingers=1, blurs=3, strength=0.08, drift=0.05, noise=0.003, shutter=0.01, flag_blur=True
    )
    distortion = (-0.03, 0.006, -0.002, 2e-4)
    lens = _lens("OPENCV_FISHEYE", 0.5, *distortion, middle=(0.501, 0.498))
    return plan(rng, [path], frames, lens, habits, name="DSC{:05d}")


def _seven(rng, frames: int) -> Shot:
    paths = [
        trajectories.ring_walk(rng, 1.3, 1.0, rng.uniform(1.2, 1.7), rng.uniform(0.35, 0.7))
        for _ in range(4)
    ]
    habits = Habits(lingers=1, blurs=2, strength=0.03, drift=0.1, noise=0.025, shutter=0.07)
    return plan(rng, paths, frames, _lens("PINHOLE", 585 / 640), habits, name="frame-{:06d}")


def _scannet(rng, frames: int) -> Shot:
    """A person who scans a room with a tablet, one lap and more around its middle."""
    path = trajectories.ring_walk(rng, 1.75, 1.5, 1.45, rng.uniform(1.2, 1.7), gaze=(0.1, 1.0))
    habits = Habits(
        lingers=3, blurs=5, strength=0.05, drift=0.15, noise=0.015, shutter=0.08, lost=3
    )
    return plan(rng, [path], frames, _lens("PINHOLE", rng.uniform(0.85, 0.92)), habits, name="{}")


def _co3d_scene(rng) -> Scene:
    if rng.random() < 0.6:
        scene = shell(rng, 5.5, 5.0)
        pedestal(scene, TABLE)
    else:
        scene = outdoors.outdoor(rng, 8.0, 5, 12)
        outdoors.block(scene, TABLE)
    with scene.as_object(SUBJECT):
        scene.pick(things.SMALL)(scene, (0, 0, TABLE), rng.uniform(0, 2 * np.pi))
    return scene


def _co3d(rng, frames: int) -> Shot:
    """Once around a thing on a table, at arm's length and a little more."""
    heights = rng.uniform(1.15, 1.55, 3)
    look = (0, 0, TABLE + 0.22)
    path = trajectories.orbit(rng, rng.uniform(0.9, 1.1), 1.15, heights, look, jitter=0.012)
    habits = Habits(lingers=3, blurs=4, strength=0.05, drift=0.15, noise=0.008, lost=1)
    return plan(rng, [path], frames, _lens("PINHOLE", rng.uniform(0.85, 1.0)), habits)


# Families film as their dataset does: rooms from within the ring between table and walls, outdoor
# scenes from a walk.
FAMILY: dict[str, Setting] = {
    "dl3dv": Setting(_dl3dv_scene, _dl3dv, 0.35, 0.7),
    "tanks_and_temples": Setting(_tanks_scene, _tanks, 0.5, 1.0),
    "mipnerf360": Setting(_mipnerf_scene, _mipnerf, 0.35, 0.6),
    "scannet_iphone": Setting(lambda rng: room(rng, 6.5, 5.6, 3), _iphone, 0.3, 0.6, metric=True),
    "scannetpp": Setting(lambda rng: room(rng, 7.0, 6.0, 4), _scannetpp, 0.3, 0.6, metric=True),
    "seven_scenes": Setting(lambda rng: room(rng, 5.0, 4.4, 1), _seven, 0.22, 0.5, metric=True),
    "scannet": Setting(
        lambda rng: living_room(rng, 6.4, 6.2), _scannet, 0.3, 0.6, 0.25, metric=True
    ),
    "co3d": Setting(_co3d_scene, _co3d, 0.25, 0.4, 0.95),
}
