"""Image files: opening them with care, and writing them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

ENCODING = {
    ".png": [cv2.IMWRITE_PNG_COMPRESSION, 1],
    ".jpg": [cv2.IMWRITE_JPEG_QUALITY, 97],
}


def load(path: Path, flags: int = cv2.IMREAD_COLOR) -> np.ndarray:
    """RGB (or grey) uint8 image.

    Raises:
        ValueError: for a missing, empty or truncated file, named.
    """
    if not path.is_file():
        raise ValueError(f"{path}: image file is missing")
    content = path.read_bytes()
    if not content:
        raise ValueError(f"{path}: image file is empty (0 bytes)")
    if _truncated(content):
        raise ValueError(f"{path}: image file is truncated ({len(content)} bytes)")
    image = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    if image is None:
        raise ValueError(f"{path}: not a readable image ({len(content)} bytes)")
    return image[..., ::-1] if image.ndim == 3 else image


def _truncated(content: bytes) -> bool:
    """Whether a PNG or JPEG lacks its end: decoders would fill the rest with grey."""
    if content.startswith(b"\x89PNG"):
        return b"IEND" not in content[-16:]
    if content.startswith(b"\xff\xd8"):
        return b"\xff\xd9" not in content[-1024:]
    return False


def write(frames: np.ndarray, folder: Path, names: list[str]) -> None:
    """Write (N, h, w, 3) RGB (or grey, or uint16) images; JPEG at quality 97, PNG lossless."""
    for frame, name in zip(frames, names, strict=True):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        stored = frame[..., ::-1] if frame.ndim == 3 else frame
        done, content = cv2.imencode(
            path.suffix, np.ascontiguousarray(stored), ENCODING[path.suffix.lower()]
        )
        if not done:
            raise ValueError(f"{path}: could not be encoded")
        path.write_bytes(content.tobytes())
