"""Camera paths as a person walks them, and filmings along them: pauses, shake, exposure, losses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from fsel.captures.colmap.camera import Camera

Curve = Callable[[np.ndarray], np.ndarray]  # (N,) parameters in 0..1 -> a value at each

SHAKEN = 0.6  # share of a burst's strength above which an owner would discard the frame
HURRY = 0.6  # natural logarithm of the most that a walk quickens or slows


@dataclass(frozen=True)
class Path:
    """A camera path over a parameter in 0..1."""

    position: Curve  # of (3,) camera centres, metres, z up
    look: Curve  # of (3,) points looked at
    roll: Curve  # radians

    def poses(self, s: np.ndarray, shake: np.ndarray) -> np.ndarray:
        """(N, 3, 4) world-to-camera poses at parameters s, turned by (N, 3) small rotations."""
        center = self.position(s)
        forward = _unit(self.look(s) - center)
        right = _unit(np.cross(forward, [0.0, 0.0, 1.0]))
        down = np.cross(forward, right)
        rotation = np.stack([right, down, forward], axis=1)
        turns = Rotation.from_rotvec(shake + np.outer(self.roll(s), [0, 0, 1]))
        turned = turns.as_matrix() @ rotation
        return np.concatenate([turned, -turned @ center[:, :, None]], axis=2)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def spline_path(rng, positions: np.ndarray, looks: np.ndarray, jitter: float) -> Path:
    """Make a path through waypoints, with a jitter of the given size in metres."""
    knots = np.linspace(0, 1, len(positions))
    fine = np.linspace(0, 1, 6 * len(positions))
    wobble = rng.normal(0, jitter, (len(fine), 3))
    position = CubicSpline(fine, CubicSpline(knots, positions)(fine) + wobble)
    roll = CubicSpline(fine, rng.normal(0, 0.015, len(fine)))
    return Path(position, CubicSpline(knots, looks), roll)


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
    rng,
    half_width: float,
    half_depth: float,
    height: float,
    loops: float,
    gaze=(0.6, 1.3),
    outward: bool = False,
) -> Path:
    """Make a walk around a room's middle, looking across it at heights within `gaze`, metres, or
    with `outward` at the walls that are near."""
    turns = int(9 * loops) + 3
    start = rng.uniform(0, 2 * np.pi)
    angle = start + rng.choice([-1, 1]) * np.linspace(0, 2 * np.pi * loops, turns)
    scale = 1 + rng.normal(0, 0.05, turns)
    x, y = half_width * scale * np.cos(angle), half_depth * scale * np.sin(angle)
    positions = np.stack([x, y, height + rng.normal(0, 0.12, turns)], axis=1)
    side = angle + np.pi * (not outward) + rng.uniform(-0.9, 0.9, turns)
    reach = rng.uniform(1.5, 2.0, turns) if outward else rng.uniform(0.1, 1.3, turns)
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
    """Return (N,) ascending parameters in 0..1 with changing speed, hardly moving where still."""
    frames = len(still)
    knots = np.linspace(0, 1, 9)
    pace = CubicSpline(knots, rng.normal(0, 0.45, 9))(np.linspace(0, 1, frames))
    speed = np.exp(np.clip(pace, -HURRY, HURRY))  # a spline overshoots its knots
    speed[still] *= 0.04
    s = np.cumsum(speed) - speed[0]
    return s / s[-1]


def bursts(rng, still: np.ndarray, count: int, strength: float) -> np.ndarray:
    """Return (N, 3) angular velocities of camera shake, radians an exposure: mild but for `count`
    runs of a few moving frames, of about `strength`."""
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
    """How a family's cameras are carried, and what their sensors do."""

    lingers: int  # runs a pass in which the camera hardly moves
    blurs: int  # bursts of shake a pass
    strength: float  # of a burst, radians an exposure
    drift: float  # of the exposure over the capture, natural logarithm
    noise: float  # standard deviation of the sensor noise, 0..1
    # share of the time between kept frames for which the shutter is open; small, as a capture keeps
    # few of a video's frames and a still camera exposes for moments
    shutter: float = 0.1
    lost: int = 0  # frames whose pose the tracker lost
    flag_blur: bool = False  # whether the owner marks shaken frames as bad


@dataclass(frozen=True)
class Shot:
    """One filming of N frames: passes over paths, and the sensor's behaviour."""

    names: tuple[str, ...]
    sequences: tuple[str, ...]  # N pass labels
    # path, parameters and angular velocities of each pass, in order
    passes: tuple[tuple[Path, np.ndarray, np.ndarray], ...]
    camera: Callable[[int, int], Camera]  # of a width and height
    habits: Habits
    exposure: np.ndarray  # (N,) gain
    bad: np.ndarray  # (N,) bool
    lost: np.ndarray  # (N,) bool

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
    name: str = "frame_{:05d}",
) -> Shot:
    """Share the frames among the paths and draw pauses, shake, exposure and losses; each of several
    passes has a folder, in which `name` counts from nought."""
    counts = [len(part) for part in np.array_split(np.arange(frames), len(paths))]
    passes = []
    for path, n in zip(paths, counts, strict=True):
        still = pauses(rng, n, min(habits.lingers, n // 6))
        s = timing(rng, still)
        passes.append((path, s, bursts(rng, still, min(habits.blurs, n // 8), habits.strength)))
    labels = [(f"seq-{k:02d}", i) for k, n in enumerate(counts, 1) for i in range(n)]
    names = [f"{label}/{name.format(i)}" for label, i in labels]
    sequences = [label for label, _ in labels]
    if len(paths) == 1:
        names, sequences = [name.format(i + 1) for i in range(frames)], ["capture"] * frames
    shaken = np.linalg.norm(np.concatenate([shake for _, _, shake in passes]), axis=1)
    lost = np.zeros(frames, dtype=bool)
    lost[rng.choice(frames, size=habits.lost, replace=False)] = True
    wave = np.cumsum(rng.normal(0, 1, frames)) / np.sqrt(frames)
    exposure = np.exp(habits.drift * (wave - wave.mean()))
    bad = (shaken > SHAKEN * habits.strength) & habits.flag_blur
    return Shot(tuple(names), tuple(sequences), tuple(passes), camera, habits, exposure, bad, lost)
