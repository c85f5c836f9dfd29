"""Camera paths as a person walks them: smooth, of changing speed, lingering here and there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

Curve = Callable[[np.ndarray], np.ndarray]
"""(N,) parameters in 0..1 -> a value at each."""

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
    """A path through waypoints, with hand jitter of the given size in metres."""
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
    """An inward orbit around the origin, climbing through the given heights."""
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
    """A walk around a room's middle, looking across it, now at walls, now at the table.

    The heights that are looked at lie within `gaze`, metres.
    """
    turns = int(9 * loops) + 3
    angle = rng.uniform(0, 2 * np.pi) + rng.choice([-1, 1]) * np.linspace(
        0, 2 * np.pi * loops, turns
    )
    scale = 1 + rng.normal(0, 0.05, turns)
    positions = np.stack(
        [
            half_width * scale * np.cos(angle),
            half_depth * scale * np.sin(angle),
            height + rng.normal(0, 0.12, turns),
        ],
        axis=1,
    )
    side = angle + np.pi + rng.uniform(-0.9, 0.9, turns)
    reach = rng.uniform(0.1, 1.3, turns)
    looks = np.stack(
        [
            half_width * reach * np.cos(side),
            half_depth * reach * np.sin(side),
            rng.uniform(*gaze, turns),
        ],
        axis=1,
    )
    return spline_path(rng, positions, looks, 0.008)


def street_walk(rng, length: float) -> Path:
    """A walk along a gentle curve past houses, the gaze swinging from side to side."""
    turns = 12
    along = np.linspace(-length / 2, length / 2, turns)
    heading = rng.uniform(0, 2 * np.pi)
    bend = rng.uniform(0.04, 0.09) * rng.choice([-1, 1])
    across = bend * (along**2 - length**2 / 8) + rng.normal(0, 0.15, turns)
    rotate = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    ground = np.stack([along, across], axis=1) @ rotate.T
    positions = np.column_stack([ground, 1.6 + rng.normal(0, 0.06, turns)])
    gaze = heading + np.cumsum(rng.normal(0, 0.45, turns)) + rng.choice([-1, 1]) * 0.9
    looks = positions + np.stack(
        [6 * np.cos(gaze), 6 * np.sin(gaze), rng.uniform(-0.6, 0.9, turns)], axis=1
    )
    return spline_path(rng, positions, looks, 0.01)


def pauses(rng, frames: int, count: int) -> np.ndarray:
    """(frames,) bool, true in `count` separate runs in which the camera lingers."""
    run = max(3, frames // 20)
    still = np.zeros(frames, dtype=bool)
    for start in run * rng.choice(frames // run, size=count, replace=False):
        still[start : start + run] = True
    return still


def timing(rng, still: np.ndarray) -> np.ndarray:
    """(N,) ascending parameters in 0..1 with changing speed, hardly moving where still (N,).

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
    """(N, 3) angular velocity of hand shake during the exposure, radians an exposure.

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
