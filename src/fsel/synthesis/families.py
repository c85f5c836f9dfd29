"""The six families: where each dataset films, how it moves, and what its sensor does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsel.recording import Camera
from fsel.synthesis import scenes, trajectories
from fsel.synthesis.scenes import Scene
from fsel.synthesis.trajectories import Path


@dataclass(frozen=True)
class Shot:
    """One filming: passes over paths, and the sensor's behaviour.

    Attributes:
        names: N frame names.
        sequences: N pass labels.
        passes: (path, parameters, angular velocities) of each pass, in order.
        camera: (width, height) -> the camera.
        exposure: (N,) gain.
        noise: standard deviation of the sensor noise, 0..1.
        vignette: darkening of the corners, 0..1.
        bad: (N,) bool.
        lost: (N,) bool.
        metric: whether the capture's world is metric and upright.
    """

    names: tuple[str, ...]
    sequences: tuple[str, ...]
    passes: tuple[tuple[Path, np.ndarray, np.ndarray], ...]
    camera: Callable[[int, int], Camera]
    exposure: np.ndarray
    noise: float
    vignette: float
    bad: np.ndarray
    lost: np.ndarray
    metric: bool

    @property
    def shake(self) -> np.ndarray:
        """(N, 3) angular velocities, radians an exposure."""
        return np.concatenate([shake for _, _, shake in self.passes])

    def poses(self, moment: np.ndarray) -> np.ndarray:
        """(N, 3, 4) world-to-camera at (N,) moments of the exposure, -0.5 to 0.5."""
        parts, at = [], 0
        for path, s, shake in self.passes:
            now = moment[at : at + len(s)]
            step = np.gradient(s) * 0.4  # the shutter is open for two fifths of a frame
            parts.append(path.poses(np.clip(s + step * now, 0, 1), shake * now[:, None]))
            at += len(s)
        return np.concatenate(parts)

    def jittered(self, rays: np.ndarray, camera: Camera, shift: np.ndarray) -> np.ndarray:
        """Rays through pixels moved by `shift`, to first order in the local ray spacing."""
        grid = rays.reshape(camera.height, camera.width, 3)
        down, across = np.gradient(grid, axis=(0, 1))
        return (grid + shift[0] * across + shift[1] * down).reshape(-1, 3)


@dataclass(frozen=True)
class Setting:
    """How a family films: scene and shot makers, and what its cameras must keep clear of."""

    scene: Callable[[np.random.Generator], Scene]
    shot: Callable[[np.random.Generator, int], Shot]
    clearance: float
    view: float


def _pinhole(focal: float) -> Callable[[int, int], Camera]:
    return lambda w, h: Camera("PINHOLE", w, h, (focal * w, focal * w, w / 2, h / 2))


def _opencv(focal: float, k1: float, k2: float) -> Callable[[int, int], Camera]:
    def make(w: int, h: int) -> Camera:
        params = (focal * w, focal * w * 1.002, w * 0.503, h * 0.497, k1, k2, 3e-4, -4e-4)
        return Camera("OPENCV", w, h, params)

    return make


def _fisheye(focal: float) -> Callable[[int, int], Camera]:
    return lambda w, h: Camera(
        "OPENCV_FISHEYE",
        w,
        h,
        (focal * w, focal * w, w * 0.501, h * 0.498, -0.03, 0.006, -0.002, 2e-4),
    )


def _shot(
    rng,
    passes: list[Path],
    frames: int,
    camera,
    *,
    lingers: int,
    blurs: int,
    strength: float,
    drift: float,
    noise: float,
    metric: bool,
    name: str = "frame_{:05d}",
    lost: int = 0,
    flag_blur: bool = False,
) -> Shot:
    counts = [len(part) for part in np.array_split(np.arange(frames), len(passes))]
    timed = tuple(
        (
            path,
            trajectories.timing(rng, n, min(lingers, n // 6)),
            trajectories.bursts(rng, n, min(blurs, n // 8), strength),
        )
        for path, n in zip(passes, counts, strict=True)
    )
    several = len(passes) > 1
    names, sequences = [], []
    for number, n in enumerate(counts, start=1):
        label = f"seq-{number:02d}" if several else "capture"
        stems = [name.format(i if several else i + 1) for i in range(n)]
        names += [f"{label}/{stem}" if several else stem for stem in stems]
        sequences += [label] * n
    shaken = np.linalg.norm(np.concatenate([shake for _, _, shake in timed]), axis=1)
    gone = np.zeros(frames, dtype=bool)
    gone[rng.choice(frames, size=lost, replace=False)] = True
    wave = np.cumsum(rng.normal(0, 1, frames)) / np.sqrt(frames)
    return Shot(
        names=tuple(names),
        sequences=tuple(sequences),
        passes=timed,
        camera=camera,
        exposure=np.exp(drift * (wave - wave.mean())),
        noise=noise,
        vignette=0.12,
        bad=(shaken > 0.6 * strength) if flag_blur else np.zeros(frames, dtype=bool),
        lost=gone,
        metric=metric,
    )


def _dl3dv_scene(rng) -> Scene:
    if rng.random() < 0.3:
        return scenes.room(rng, 8.0, 6.5, 3)
    scene = scenes.outdoor(rng, 8.0, 6, 9)
    for _ in range(6):
        angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(2.6, 6.5)
        spot = (distance * np.cos(angle), distance * np.sin(angle), 0)
        scene.box(rng.uniform(0.5, 1.3, 3), spot, scene.material(3, 0.25), angle)
    scenes.monument(scene, 1.3)
    return scene


def _dl3dv(rng, frames: int) -> Shot:
    style = rng.integers(3)
    if style == 0:
        path = trajectories.street_walk(rng, rng.uniform(7, 10))
    elif style == 1:
        path = trajectories.orbit(rng, rng.uniform(0.7, 1.2), 3.6, (1.5, 1.8), (0, 0, 1.2))
    else:
        path = trajectories.ring_walk(rng, 2.3, 1.9, 1.5, rng.uniform(0.9, 1.5))
    camera = _opencv(rng.uniform(0.75, 0.9), -0.03, 0.008)
    return _shot(
        rng,
        [path],
        frames,
        camera,
        lingers=3,
        blurs=4,
        strength=0.05,
        drift=0.15,
        noise=0.008,
        metric=False,
    )


def _tanks_scene(rng) -> Scene:
    scene = scenes.outdoor(rng, 8.5, 5, 10)
    scenes.monument(scene, rng.uniform(2.2, 2.8))
    return scene


def _tanks(rng, frames: int) -> Shot:
    path = trajectories.orbit(rng, rng.uniform(1.0, 1.5), 4.3, (1.5, 2.3, 1.6), (0, 0, 1.3))
    return _shot(
        rng,
        [path],
        frames,
        _pinhole(rng.uniform(0.75, 0.85)),
        lingers=3,
        blurs=3,
        strength=0.04,
        drift=0.2,
        noise=0.006,
        metric=False,
        lost=2,
    )


def _mipnerf_scene(rng) -> Scene:
    scene = scenes.outdoor(rng, 11.0, 4, 16)
    scenes.still_life(scene)
    return scene


def _mipnerf(rng, frames: int) -> Shot:
    path = trajectories.orbit(rng, 2.7, 2.0, (1.1, 1.5, 2.0), (0, 0, 0.75))
    return _shot(
        rng,
        [path],
        frames,
        _pinhole(rng.uniform(0.8, 0.95)),
        lingers=2,
        blurs=2,
        strength=0.03,
        drift=0.05,
        noise=0.004,
        metric=False,
    )


def _iphone(rng, frames: int) -> Shot:
    path = trajectories.ring_walk(rng, 1.9, 1.5, 1.45, rng.uniform(1.2, 1.8))
    return _shot(
        rng,
        [path],
        frames,
        _opencv(0.78, 0.02, -0.01),
        lingers=4,
        blurs=9,
        strength=0.09,
        drift=0.35,
        noise=0.012,
        metric=True,
        name="frame_{:06d}",
        lost=2,
    )


def _scannetpp(rng, frames: int) -> Shot:
    path = trajectories.ring_walk(rng, 2.0, 1.6, 1.5, rng.uniform(1.6, 2.4))
    return _shot(
        rng,
        [path],
        frames,
        _fisheye(0.5),
        lingers=1,
        blurs=3,
        strength=0.08,
        drift=0.05,
        noise=0.003,
        metric=True,
        name="DSC{:05d}",
        flag_blur=True,
    )


def _seven(rng, frames: int) -> Shot:
    passes = [
        trajectories.ring_walk(rng, 1.3, 1.0, rng.uniform(1.2, 1.7), rng.uniform(0.35, 0.7))
        for _ in range(4)
    ]
    return _shot(
        rng,
        passes,
        frames,
        _pinhole(585 / 640),
        lingers=1,
        blurs=2,
        strength=0.06,
        drift=0.1,
        noise=0.025,
        metric=True,
        name="frame-{:06d}",
    )


FAMILY: dict[str, Setting] = {
    "dl3dv": Setting(_dl3dv_scene, _dl3dv, 0.35, 0.7),
    "tanks_and_temples": Setting(_tanks_scene, _tanks, 0.5, 1.0),
    "mipnerf360": Setting(_mipnerf_scene, _mipnerf, 0.35, 0.6),
    "scannet_iphone": Setting(lambda rng: scenes.room(rng, 6.5, 5.6, 3), _iphone, 0.3, 0.6),
    "scannetpp": Setting(lambda rng: scenes.room(rng, 7.0, 6.0, 4), _scannetpp, 0.3, 0.6),
    "seven_scenes": Setting(lambda rng: scenes.room(rng, 5.0, 4.4, 1), _seven, 0.22, 0.5),
}
"""Rooms are filmed from within the ring between table and walls, outdoor scenes from a walk."""
