"""Videos to watch: frames into an .mp4 that browsers play, and captions on frames."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

CODECS = ("avc1", "vp09", "mp4v")  # H.264 where OpenCV's FFmpeg encodes it, VP9, MPEG-4
BAR = 30  # pixels of a caption's height, of images 480 pixels wide
FONT = cv2.FONT_HERSHEY_SIMPLEX


def write(path: Path, frames: Iterable[np.ndarray], rate: int) -> None:
    """Write (h, w, 3) uint8 RGB frames of one size; an odd last row or column is left out.

    Raises:
        OSError: naming the file, when no codec is there.
    """
    writer = None
    for frame in frames:
        height, width = (side // 2 * 2 for side in frame.shape[:2])
        writer = writer or _opened(path, rate, (width, height))
        writer.write(np.ascontiguousarray(frame[:height, :width, ::-1]))
    if writer is not None:
        writer.release()


def _opened(path: Path, rate: int, size: tuple[int, int]) -> cv2.VideoWriter:
    for codec in CODECS:
        code = cv2.VideoWriter.fourcc(*codec)
        writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, rate, size)
        if writer.isOpened():
            return writer
    raise OSError(f"{path}: OpenCV has no codec for it; tried: {', '.join(CODECS)}")


def captioned(image: np.ndarray, caption: str) -> np.ndarray:
    """An (h, w, 3) uint8 RGB image below a white bar with a caption."""
    scale = max(image.shape[1] / 480, 0.5)
    bar = np.full((round(BAR * scale), image.shape[1], 3), 255, np.uint8)
    place = (round(6 * scale), round((BAR - 10) * scale))
    cv2.putText(
        bar, caption, place, FONT, 0.55 * scale, (0, 0, 0), max(round(scale), 1), cv2.LINE_AA
    )
    return np.vstack([bar, image])


def levels(image: np.ndarray) -> np.ndarray:
    """Levels 0..255, uint8, of an image in [0, 1]."""
    return np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
