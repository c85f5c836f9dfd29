"""What every layout's reader returns, and how readers refuse what is wrong."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fsel.recording import Camera, Recording

OPENGL_TO_OPENCV = np.diag([1.0, -1.0, -1.0])
OLD_APPLIED_TRANSFORM = np.array([[0.0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]])
"""World rotation of nerfstudio's COLMAP import before January 2024."""


@dataclass(frozen=True)
class RawPoints:
    """Sparse points; tracks refer to frames by the raw capture's order.

    Attributes:
        xyz: (M, 3) float64.
        rgb: (M, 3) uint8.
        track_point: (L,) int64.
        track_frame: (L,) int64.
    """

    xyz: np.ndarray
    rgb: np.ndarray
    track_point: np.ndarray
    track_frame: np.ndarray


@dataclass(frozen=True)
class RawCapture:
    """A capture as its files say, before images are opened.

    Attributes:
        names: frame names, any order.
        images: file of each frame.
        world_to_camera: (N, 3, 4) float64, OpenCV axes.
        cameras: one a frame, at the size that the files state.
        sequences: pass label of each frame.
        masks: mask file of each frame, or None.
        points: reads the sparse points, which takes a while; None where there are none.
        dropped: frames left out, and why.
    """

    names: list[str]
    images: list[Path]
    world_to_camera: np.ndarray
    cameras: list[Camera]
    sequences: list[str]
    masks: list[Path] | None = None
    points: Callable[[], RawPoints | None] | None = None
    dropped: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Layout:
    """A dataset's way of lying on disk.

    Attributes:
        name: key in the registry and in the config.
        recognises: (folder) -> whether it looks like this layout.
        read: (folder) -> raw capture.
        write: (recording, folder) -> None, for the layouts that embedded captures use.
    """

    name: str
    recognises: Callable[[Path], bool]
    read: Callable[[Path], RawCapture]
    write: Callable[[Recording, Path], None] | None = None


def read_json(path: Path) -> dict:
    """Parse a JSON object, naming the file when that fails."""
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise ValueError(f"{path}: not readable as JSON ({error})") from error
    if not isinstance(content, dict):
        raise ValueError(f"{path}: expected a JSON object, got {type(content).__name__}")
    return content


def inside(folder: Path, relative: str, source: Path) -> Path:
    """A path that a file names, refused where it leads out of the capture."""
    path = (folder / relative).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{source}: file_path {relative!r} leads outside {folder}")
    return path


def natural(name: str) -> list:
    """Sort key: digit runs compare as numbers."""
    return [(int(p), "") if p.isdigit() else (-1, p) for p in re.split(r"(\d+)", name) if p]


def invert_pose(camera_to_world: np.ndarray) -> np.ndarray:
    """(3, 4) world-to-camera of a (3+, 4) rigid camera-to-world, by transposing its rotation."""
    rotation, center = camera_to_world[:3, :3].T, camera_to_world[:3, 3]
    return np.concatenate([rotation, (-rotation @ center)[:, None]], axis=1)
