"""Varied families: a family's places, filmed another way each time.

Path, speed, blur, exposure, noise and lens are drawn anew for every shot, and things are put where
its cameras look.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from fsel.geometry import camera_centers
from fsel.layouts.recording import Camera
from fsel.synthesis import solids, things
from fsel.synthesis import textures as tx
from fsel.synthesis.caster import Caster
from fsel.synthesis.setting import Setting
from fsel.synthesis.shot import Habits, Shot, plan
from fsel.synthesis.solids import Scene
from fsel.synthesis.trajectories import Curve, Path

LONGEST = 1.3  # greatest factor of the focal length
WIDEST = 0.35  # metres from a thing's middle to its side
FARTHEST = 6.0  # metres from a camera to a thing
HIGHEST = 1.3  # metres above the ground of what a thing may stand on
ROOM = 0.2  # metres around a thing's trunk in which nothing else stands
APART = 0.5  # metres between things
TRIES = 24  # spots looked at for a thing


def varied(setting: Setting) -> Setting:
    """A setting in which every shot differs in its path, speed, sensor, lens and clutter.

    Args:
        setting: of the family; its clearance and view hold for the varied one too. The focal
            length varies by a factor of `shortest` to `LONGEST`.
    """
    keep = max(setting.clearance + WIDEST, setting.view + WIDEST / 2)

    def shot(rng: np.random.Generator, frames: int) -> Shot:
        usual = setting.shot(rng, frames)
        paths = [_other_path(rng, path) for path, _, _ in usual.passes]
        camera = _other_lens(usual.camera, _spread(rng, setting.shortest, LONGEST))
        return plan(rng, paths, frames, camera, _other_habits(rng, usual.habits))

    return replace(setting, shot=shot, clutter=lambda caster, shot: cluttered(caster, shot, keep))


def _spread(rng, low: float, high: float) -> float:
    """A number between two, its logarithm uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _other_habits(rng, usual: Habits) -> Habits:
    return replace(
        usual,
        lingers=int(rng.integers(11)),
        hurry=_spread(rng, 0.15, 1.2),
        blurs=int(rng.integers(11)),
        strength=usual.strength * _spread(rng, 0.5, 1.8),
        shutter=min(usual.shutter * _spread(rng, 0.4, 2.5), 0.25),
        drift=rng.uniform(0, 0.6),
        noise=_spread(rng, 0.002, 0.03),
    )


def _other_lens(usual: Callable[[int, int], Camera], factor: float) -> Callable[[int, int], Camera]:
    """The same lens with another focal length; its distortion is unitless."""

    def make(w: int, h: int) -> Camera:
        camera = usual(w, h)
        fx, fy, *rest = camera.params
        return replace(camera, params=(factor * fx, factor * fy, *rest))

    return make


def _other_path(rng, path: Path) -> Path:
    """A path of another shape, walked in another order, the gaze swung to the sides."""
    along = _order(rng)
    stretch = _stretch(rng)
    offset = _smooth(rng, np.array([0.06, 0.06, 0.1]) * rng.uniform(0, 1, 3))
    swing = _smooth(rng, np.array([0.3, 0.06]) * rng.uniform(0, 1, 2))

    def position(s: np.ndarray) -> np.ndarray:
        return path.position(along(s)) @ stretch + offset(s)

    def look(s: np.ndarray) -> np.ndarray:
        flat = stretch * [[1, 1, 0], [1, 1, 0], [0, 0, 0]] + np.diag([0, 0, 1])
        center = position(s)
        x, y, z = (path.look(along(s)) @ flat - center).T
        yaw, pitch = swing(s).T
        ahead = np.hypot(x, y)
        turned = [x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)]
        return center + np.column_stack([*turned, z + ahead * pitch])

    return Path(position, look, lambda s: path.roll(along(s)))


def _stretch(rng) -> np.ndarray:
    """(3, 3) symmetric matrix that stretches the ground unevenly, and the height."""
    angle = rng.uniform(0, np.pi)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return turn @ np.diag(rng.uniform(0.85, 1.15, 3)) @ turn.T


def _smooth(rng, size: np.ndarray) -> Curve:
    """A curve of (d,) values that change slowly, of (d,) standard deviations."""
    knots = np.linspace(0, 1, 8)
    return CubicSpline(knots, np.clip(rng.normal(0, 1, (8, len(size))), -1.5, 1.5) * size)


def _order(rng) -> Curve:
    """Parameter of the usual path over that of the new one: all or a part, or back and on again."""
    part = rng.uniform(0.55, 1) if rng.random() < 0.5 else 1.0
    start = rng.uniform(0, 1 - part)
    turns = np.array([0.0, 1.0])
    if rng.random() < 0.4:
        turn = rng.uniform(0.4, 0.8)
        turns = np.array([0, turn, turn - rng.uniform(0.15, 0.4), 1])
    walked = np.concatenate([[0], np.cumsum(np.abs(np.diff(turns)))])
    return PchipInterpolator(walked / walked[-1], start + part * turns)


def cluttered(caster: Caster, shot: Shot, keep: float) -> Caster:
    """Up to eight things added to a scene where cameras look, and the scene cast anew.

    Args:
        caster: of the scene, which is added to.
        shot: whose cameras look.
        keep: least distance over ground from a thing's middle to any camera, metres.
    """
    scene = caster.scene
    poses = shot.poses(np.zeros(len(shot.names)))
    taken = camera_centers(poses)[:, :2]
    reach = np.full(len(taken), keep)
    for _ in range(int(scene.rng.integers(9))):
        for _ in range(TRIES):
            at, gaze = _spot(caster, poses)
            free = np.linalg.norm(taken - at[:2], axis=1) >= reach
            if free.all() and abs(at[2]) <= HIGHEST and _roomy(caster, at):
                _thing(scene, at, gaze)
                taken, reach = np.vstack([taken, at[:2]]), np.append(reach, APART)
                break
    return Caster(scene)


def _spot(caster: Caster, poses: np.ndarray) -> tuple[np.ndarray, float]:
    """A place to stand before what some camera sees, and the height of the gaze above it."""
    rng = caster.scene.rng
    pose = poses[rng.integers(len(poses))]
    center, ahead = -pose[:, :3].T @ pose[:, 3], pose[2, :3]
    seen = center + ahead * rng.uniform(0.3, 0.85) * min(_met(caster, center, ahead), FARTHEST)
    above = np.array([seen[0], seen[1], center[2]])
    ground = center[2] - _met(caster, above, np.array([0.0, 0.0, -1.0]))
    return np.array([seen[0], seen[1], ground]), seen[2] - ground


def _met(caster: Caster, origin: np.ndarray, ray: np.ndarray) -> float:
    """Distance to what a unit ray meets, infinite for nothing."""
    which, distance = caster.hit(origin[None].astype(np.float32), ray[None].astype(np.float32))
    return float(distance[0]) if which[0] >= 0 else np.inf


def _roomy(caster: Caster, at: np.ndarray) -> bool:
    """Whether nothing stands close to a place, a little above its ground."""
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(16)])
    return bool(caster.clearance((at + [0, 0, 0.1])[None], around)[0] >= ROOM)


def _thing(scene: Scene, at: np.ndarray, gaze: float) -> None:
    """A thing of the height of the gaze: on a stand, unless it is high enough alone."""
    rng = scene.rng
    height = min(gaze - rng.uniform(0.1, 0.45), HIGHEST)
    if height > 0.15:
        side = rng.uniform(0.16, 0.34)
        kind = scene.pick((tx.PLANK, tx.BRICK, tx.COBBLE, tx.STRIPE))
        tint = scene.pick((solids.WOOD, solids.OAK, solids.STONE, *solids.CLOTHS))
        material = scene.material(kind, 0.15, tint)
        if rng.random() < 0.5:
            scene.cylinder(side / 2, height, at, material)
        else:
            scene.box((side, side, height), at, material, rng.uniform(0, np.pi))
        at = at + [0, 0, height]
    if rng.random() < 0.3:
        solids.plant(scene, at)
    else:
        scene.pick(things.SMALL)(scene, at, rng.uniform(0, 2 * np.pi))
