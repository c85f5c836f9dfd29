"""Frames out of a video: the sharpest of each stretch of time, upright, by the clock."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from fsel.images import files as image_files
from fsel.images.previews import Progress, in_silence
from fsel.images.sharpness import variance_of_laplacian
from fsel.utils.wording import counted

ENDINGS = (".mp4", ".mov", ".m4v", ".mkv", ".avi", ".webm", ".mts", ".3gp")
MOST = 300  # frames that a video is thinned to unless told otherwise
RATE = 4.0  # of them a second at most: a person walks some 35 cm between two
LEAST = 3
SIDE = 480  # pixels of the longer side of the images whose sharpness is compared


@dataclass(frozen=True)
class Kept:
    """A frame of a video that was kept.

    Attributes:
        index: of the video's frames, from 0.
        seconds: from the start, by the video's clock.
        sharpness: variance of the Laplacian, comparable within a video.
    """

    index: int
    seconds: float
    sharpness: float


def is_video(path: Path) -> bool:
    """Check whether a path is a file with a video's ending."""
    return path.suffix.lower() in ENDINGS and path.is_file()


def thin(
    path: Path,
    folder: Path,
    *,
    frames: int | None = None,
    rate: float | None = None,
    progress: Progress = in_silence,
) -> list[Kept]:
    """Write the sharpest frame of each of many equal stretches of a video, as JPEG.

    Stretches are of equal time, not of equal numbers of frames, so that videos of variable rate
    are thinned evenly. Frames are turned upright as the file says. One frame is in memory.

    Args:
        path: the video.
        folder: receives `frame_00000.jpg`, ..., numbered by the video's frames.
        frames: how many stretches; None for as many as `rate` gives, 300 at most.
        rate: stretches a second; None for 4, or what `frames` needs.
        progress: wraps the loop over the video's frames.

    Returns:
        The frames that were kept, in order.

    Raises:
        ValueError: when the file cannot be read as a video, or has fewer than three frames.
    """
    film = cv2.VideoCapture(str(path))
    if not film.isOpened():
        raise ValueError(f"{path}: not a readable video")
    film.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
    count, per_second = int(film.get(cv2.CAP_PROP_FRAME_COUNT)), film.get(cv2.CAP_PROP_FPS)
    lasts = count / per_second if count > 0 and per_second > 0 else 0.0
    pace = _pace(frames, rate, lasts)
    kept: list[Kept] = []
    best: tuple[Kept, np.ndarray] | None = None
    stretch = 0
    for shot, image in progress(_shots(film, per_second), max(count, 0)):
        at = int(shot.seconds * pace + 1e-6)
        if best is not None and at > stretch:
            kept.append(_written(best, folder))
            best = None
        if best is None or shot.sharpness > best[0].sharpness:
            best = shot, image
        stretch = at
    if best is not None:
        kept.append(_written(best, folder))
    if len(kept) < LEAST:
        raise ValueError(
            f"{path}: gives {counted(len(kept), 'frame')} over {lasts:.1f} s; at least {LEAST} are "
            "needed. Hint: --video-frames or --rate take more of it"
        )
    return kept


def _pace(frames: int | None, rate: float | None, lasts: float) -> float:
    """Stretches a second."""
    if frames is not None and lasts > 0:
        return frames / lasts
    if rate is not None or lasts <= 0:
        return rate or RATE
    return min(RATE, MOST / lasts)


def _shots(film: cv2.VideoCapture, per_second: float) -> Iterator[tuple[Kept, np.ndarray]]:
    """Every frame with its time and sharpness; (h, w, 3) uint8 BGR, upright."""
    index, last = 0, -1.0
    while film.grab():
        seconds = film.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if not seconds > last:  # a container without times of its own
            seconds = index / per_second if per_second > 0 else float(index)
        last = seconds
        done, image = film.retrieve()
        if done:
            yield Kept(index, seconds, _sharpness(image)), image
        index += 1


def _sharpness(image: np.ndarray) -> float:
    scale = SIDE / max(image.shape[:2])
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if scale < 1:
        grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return variance_of_laplacian(grey)


def _written(best: tuple[Kept, np.ndarray], folder: Path) -> Kept:
    kept, image = best
    image_files.write(image[None, ..., ::-1], folder, [f"frame_{kept.index:05d}.jpg"])
    return kept
