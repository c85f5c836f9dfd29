"""What exports of photogrammetry programs share: files by their heads, images by their labels."""

from __future__ import annotations

import logging
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.captures.layouts import bare
from fsel.captures.parsing import slashed
from fsel.core.geometry import camera_centers, poses_at

HEAD = 4096  # bytes that tell what a file is
FAR = 1000  # times the cameras' reach: a world so far off loses digits in float32
LEAST = 0.5  # pixels
log = logging.getLogger(__name__)


def marked(folder: Path, pattern: str, *marks: bytes) -> list[Path]:
    """Return a folder's files of a pattern whose first bytes have all of the marks."""
    found = []
    for path in sorted(folder.glob(pattern)):
        if path.is_file():
            with path.open("rb") as file:
                head = file.read(HEAD)
            found += [path] * all(mark in head for mark in marks)
    return found


def only(files: list[Path], folder: Path, what: str) -> Path:
    """Return the file that must be there once."""
    if len(files) != 1:
        there = ", ".join(file.name for file in files) or "none"
        raise ValueError(f"{folder}: {what}: {there}; allowed: one")
    return files[0]


def images_of(folder: Path, labels: list[str], source: Path) -> list[Path]:
    """Return a capture's images by label: a file's name in any case, with its ending, another one
    or none. One that is not there is named as the label says."""
    there: dict[str, list[Path]] = {}
    for file in bare.find(folder):
        for key in {file.name.lower(), file.stem.lower()}:
            there.setdefault(key, []).append(file)
    images = []
    for label in labels:
        name = PurePosixPath(slashed(label)).name
        files = there.get(name.lower()) or there.get(Path(name).stem.lower()) or [folder / name]
        if len(files) > 1:
            raise ValueError(f"{source}: {label!r} may be {files[0].name} or {files[1].name}")
        images.append(files[0])
    return images


def near_origin(poses: np.ndarray, source: Path) -> np.ndarray:
    """Return (N, 3, 4) poses in a world that is moved to its cameras where it is georeferenced:
    coordinates of millions lose their digits in a trainer's float32."""
    centers = camera_centers(poses)
    middle = np.round(np.median(centers, axis=0))
    if not np.abs(middle).max() > FAR * np.abs(centers - middle).max():
        return poses
    log.info("%s: coordinates are far from zero; the world is moved by %s", source, -middle)
    return poses_at(centers - middle, poses[:, :, :3])


def negligible(pixels: float, path: Path, what: str) -> None:
    """Refuse a lens's term that no camera model here has, if it moves a corner by half a pixel."""
    if not abs(pixels) < LEAST:
        raise ValueError(
            f"{path}: {what} moves the image's corners by {pixels:.2g} pixels; allowed: below "
            f"{LEAST}. Hint: calibrate without it, or export undistorted images"
        )
