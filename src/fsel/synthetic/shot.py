"""One filming of a scene: passes along paths, and how the sensor behaves on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.synthetic import trajectories
from fsel.synthetic.trajectories import Path

SHAKEN = 0.6  # share of a burst's strength above which an owner would discard the frame


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
        """(N, 3, 4) world-to-camera at (N,) moments of the exposure, -0.5 to 0.5."""
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
    still = trajectories.pauses(rng, frames, min(habits.lingers, frames // 6))
    s = trajectories.timing(rng, still)
    return s, trajectories.bursts(rng, still, min(habits.blurs, frames // 8), habits.strength)


def _labels(counts: list[int], name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Frame names and pass labels; several passes have folders and count from nought."""
    if len(counts) == 1:
        return tuple(name.format(i + 1) for i in range(counts[0])), ("capture",) * counts[0]
    labels = [(f"seq-{k:02d}", i) for k, n in enumerate(counts, start=1) for i in range(n)]
    names = tuple(f"{label}/{name.format(i)}" for label, i in labels)
    return names, tuple(label for label, _ in labels)
