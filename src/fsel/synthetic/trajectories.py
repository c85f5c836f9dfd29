"""Camera paths as a person walks them, and filmings along them: pauses, shake, exposure, losses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from fsel.captures.colmap.camera import Camera

Curve = Callable[[np.ndarray], np.ndarray]
"""(N,) parameters in 0..1 -> a value at each."""

SHAKEN = 0.6  # share of a burst's strength above which an owner would discard the frame
HURRY = 0.6  # natural logarithm of the most that a walk quickens or slows


@dataclass(frozen=True)
class Path:
    """A camera path over a parameter in 0..1.

    Attributes:
        position: of (3,) camera centres, metres, z up.
        look: of (3,) points looked at.
        roll: of the roll, radians.
    """

    position: Curve
    look: Curve
    roll: Curve

    def poses(self, s: np.ndarray, shake: np.ndarray) -> np.ndarray:
        """(N, 3, 4) world-to-camera poses at parameters s, turned by (N, 3) small rotations."""
        center, target = self.position(s), self.look(s)
        forward = _unit(target - center)
        right = _unit(np.cross(forward, [0.0, 0.0, 1.0]))
        down = np.cross(forward, right)
        rotation = np.stack([right, down, forward], axis=1)
        turns = Rotation.from_rotvec(shake + np.outer(self.roll(s), [0, 0, 1]))
        turned = turns.as_matrix() @ rotation
        return np.concatenate([turned, -turned @ center[:, :, None]], axis=2)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def spline_path(rng, positions: np.ndarray, looks: np.ndarray, jitter: float) -> Path:
    """Make a path through waypoints, with hand jitter of the given size in metres."""
    knots = np.linspace(0, 1, len(positions))
    fine = np.linspace(0, 1, 6 * len(positions))
    wobble = rng.normal(0, jitter, (len(fine), 3))
    position = CubicSpline(fine, CubicSpline(knots, positions)(fine) + wobble)
    return Path(
        position=position,
        look=CubicSpline(knots, looks),
        roll=CubicSpline(fine, rng.normal(0, 0.015, len(fine))),
    )


def orbit(rng, loops: float, radius: float, heights, look, jitter: float = 0.01) -> Path:
    """Make an inward orbit around the origin, climbing through the given heights."""
    turns = int(9 * loops) + 3
    start = rng.uniform(0, 2 * np.pi)
    angle = start + rng.choice([-1, 1]) * np.linspace(0, 2 * np.pi * loops, turns)
    reach = radius * (1 + rng.normal(0, 0.06, turns))
    height = np.interp(np.linspace(0, 1, turns), np.linspace(0, 1, len(heights)), heights)
    height = height + rng.normal(0, 0.05, turns)
    positions = np.stack([reach * np.cos(angle), reach * np.sin(angle), height], axis=1)
    looks = np.asarray(look, float) + rng.normal(0, 0.12 * radius**0.5, (turns, 3)) * [1, 1, 0.5]
    return spline_path(rng, positions, looks, jitter)


def ring_walk(
    rng, half_width: float, half_depth: float, height: float, loops: float, gaze=(0.6, 1.3)
) -> Path:
    """Make a walk around a room's middle, looking across it, now at walls, now at the table.

    The heights that are looked at lie within `gaze`, metres.
    """
    turns = int(9 * loops) + 3
    start = rng.uniform(0, 2 * np.pi)
    angle = start + rng.choice([-1, 1]) * np.linspace(0, 2 * np.pi * loops, turns)
    scale = 1 + rng.normal(0, 0.05, turns)
    x, y = half_width * scale * np.cos(angle), half_depth * scale * np.sin(angle)
    positions = np.stack([x, y, height + rng.normal(0, 0.12, turns)], axis=1)
    side = angle + np.pi + rng.uniform(-0.9, 0.9, turns)
    reach = rng.uniform(0.1, 1.3, turns)
    x, y = half_width * reach * np.cos(side), half_depth * reach * np.sin(side)
    looks = np.stack([x, y, rng.uniform(*gaze, turns)], axis=1)
    return spline_path(rng, positions, looks, 0.008)


def street_walk(rng, length: float) -> Path:
    """Make a walk along a gentle curve past houses, the gaze swinging from side to side."""
    turns = 12
    along = np.linspace(-length / 2, length / 2, turns)
    heading = rng.uniform(0, 2 * np.pi)
    bend = rng.uniform(0.04, 0.09) * rng.choice([-1, 1])
    across = bend * (along**2 - length**2 / 8) + rng.normal(0, 0.15, turns)
    rotate = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    ground = np.stack([along, across], axis=1) @ rotate.T
    positions = np.column_stack([ground, 1.6 + rng.normal(0, 0.06, turns)])
    gaze = heading + np.cumsum(rng.normal(0, 0.45, turns)) + rng.choice([-1, 1]) * 0.9
    ahead = [6 * np.cos(gaze), 6 * np.sin(gaze), rng.uniform(-0.6, 0.9, turns)]
    looks = positions + np.stack(ahead, axis=1)
    return spline_path(rng, positions, looks, 0.01)


def pauses(rng, frames: int, count: int) -> np.ndarray:
    """Return (frames,) bool, true in `count` separate runs in which the camera lingers."""
    run = max(3, frames // 20)
    still = np.zeros(frames, dtype=bool)
    for start in run * rng.choice(frames // run, size=count, replace=False):
        still[start : start + run] = True
    return still


def timing(rng, still: np.ndarray) -> np.ndarray:
    """Return (N,) ascending parameters in 0..1 with changing speed, hardly moving where still (N,).

    The walk quickens or slows by a factor of at most exp(HURRY).
    """
    frames = len(still)
    knots = np.linspace(0, 1, 9)
    pace = CubicSpline(knots, rng.normal(0, 0.45, 9))(np.linspace(0, 1, frames))
    speed = np.exp(np.clip(pace, -HURRY, HURRY))  # a spline overshoots its knots
    speed[still] *= 0.04
    s = np.cumsum(speed) - speed[0]
    return s / s[-1]


def bursts(rng, still: np.ndarray, count: int, strength: float) -> np.ndarray:
    """Return (N, 3) angular velocity of hand shake during the exposure, radians an exposure.

    Mild everywhere; `count` runs of a few frames, none of them still (N,), are shaken `strength`
    radians.
    """
    shake = rng.normal(0, 0.0015, (len(still), 3))
    free = np.flatnonzero(~still)
    for start in rng.choice(free, size=count, replace=False):
        run = np.arange(start, min(start + rng.integers(2, 6), len(still)))
        direction = rng.normal(size=3) * [1, 1, 0.3]
        direction /= np.linalg.norm(direction)
        shake[run[~still[run]]] += strength * rng.uniform(0.6, 1.2) * direction
    return shake


@dataclass(frozen=True)
class Habits:
    """Habits of a family: how its cameras are held and what their sensors do.

    Attributes:
        lingers: runs a pass in which the camera hardly moves.
        blurs: bursts of shake a pass.
        strength: of a burst, radians an exposure.
        shutter: share of the time between kept frames for which the shutter is open; small, as
            a capture keeps few of a video's frames and a still camera exposes for moments.
        drift: of the exposure over the capture, natural logarithm.
        noise: standard deviation of the sensor noise, 0..1.
        metric: whether the capture's world is metric and upright.
        name: format of the frame names.
        lost: frames whose pose the tracker lost.
        flag_blur: whether the owner marks shaken frames as bad.
    """

    lingers: int
    blurs: int
    strength: float
    drift: float
    noise: float
    shutter: float = 0.1
    metric: bool = False
    name: str = "frame_{:05d}"
    lost: int = 0
    flag_blur: bool = False


@dataclass(frozen=True)
class Shot:
    """One filming: passes over paths, and the sensor's behaviour.

    Attributes:
        names: N frame names.
        sequences: N pass labels.
        passes: (path, parameters, angular velocities) of each pass, in order.
        camera: (width, height) -> the camera.
        habits: of the family.
        exposure: (N,) gain.
        bad: (N,) bool.
        lost: (N,) bool.
    """

    names: tuple[str, ...]
    sequences: tuple[str, ...]
    passes: tuple[tuple[Path, np.ndarray, np.ndarray], ...]
    camera: Callable[[int, int], Camera]
    habits: Habits
    exposure: np.ndarray
    bad: np.ndarray
    lost: np.ndarray

    def poses(self, moment: np.ndarray) -> np.ndarray:
        """Return (N, 3, 4) world-to-camera at (N,) moments of the exposure, -0.5 to 0.5."""
        parts, at = [], 0
        for path, s, shake in self.passes:
            now = moment[at : at + len(s)]
            step = np.gradient(s) * self.habits.shutter
            parts.append(path.poses(np.clip(s + step * now, 0, 1), shake * now[:, None]))
            at += len(s)
        return np.concatenate(parts)


def plan(
    rng: np.random.Generator,
    paths: list[Path],
    frames: int,
    camera: Callable[[int, int], Camera],
    habits: Habits,
) -> Shot:
    """Share the frames among the paths and draw pauses, shake, exposure and losses."""
    counts = [len(part) for part in np.array_split(np.arange(frames), len(paths))]
    passes = tuple((path, *_pass(rng, n, habits)) for path, n in zip(paths, counts, strict=True))
    names, sequences = _labels(counts, habits.name)
    shaken = np.linalg.norm(np.concatenate([shake for _, _, shake in passes]), axis=1)
    lost = np.zeros(frames, dtype=bool)
    lost[rng.choice(frames, size=habits.lost, replace=False)] = True
    wave = np.cumsum(rng.normal(0, 1, frames)) / np.sqrt(frames)
    return Shot(
        names=names,
        sequences=sequences,
        passes=passes,
        camera=camera,
        habits=habits,
        exposure=np.exp(habits.drift * (wave - wave.mean())),
        bad=(shaken > SHAKEN * habits.strength) & habits.flag_blur,
        lost=lost,
    )


def _pass(rng, frames: int, habits: Habits) -> tuple[np.ndarray, np.ndarray]:
    """Path parameters and shake of one pass: it is never shaken where it lingers."""
    still = pauses(rng, frames, min(habits.lingers, frames // 6))
    s = timing(rng, still)
    return s, bursts(rng, still, min(habits.blurs, frames // 8), habits.strength)


def _labels(counts: list[int], name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Frame names and pass labels; several passes have folders and count from nought."""
    if len(counts) == 1:
        return tuple(name.format(i + 1) for i in range(counts[0])), ("capture",) * counts[0]
    labels = [(f"seq-{k:02d}", i) for k, n in enumerate(counts, start=1) for i in range(n)]
    names = tuple(f"{label}/{name.format(i)}" for label, i in labels)
    return names, tuple(label for label, _ in labels)
