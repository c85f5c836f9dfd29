"""Sharpness of images, and reduced images of many files, decoded at that size where possible."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import cv2
import numpy as np

from fsel.captures.images import files as image_files
from fsel.core.threads import side_by_side

LUMA = np.array([0.299, 0.587, 0.114])
SHARPNESS_SIDE = 480  # pixels at least: half a 4K frame's motion blur is still seen there
MANY = 10_000  # files from which on half that size is enough: decoding is all that takes time
MOST_SHOWN = 3000  # frames of a page at most, beside the picks: 50,000 would take 12 MB
SIDE, LARGE, LEAST = 240, 300, 48  # pixels of a picture where so many are shown; with more, fewer
GREY = {
    1: cv2.IMREAD_GRAYSCALE,
    2: cv2.IMREAD_REDUCED_GRAYSCALE_2,
    4: cv2.IMREAD_REDUCED_GRAYSCALE_4,
    8: cv2.IMREAD_REDUCED_GRAYSCALE_8,
}

Progress = Callable[[Iterable, int], Iterable]
"""(items, how many) -> the same items, with a progress bar."""


def in_silence(items: Iterable, count: int) -> Iterable:
    """Return the progress that shows nothing."""
    return items


def sharpness(images: np.ndarray) -> np.ndarray:
    """Return (N,) float64 variances of the Laplacian of (N, h, w, 3) uint8 RGB images' luma."""
    return np.array([variance_of_laplacian(np.asarray(image) @ LUMA) for image in images])


def variance_of_laplacian(grey: np.ndarray) -> float:
    """Return the sharpness of one (h, w) grey image, uint8 or float64."""
    return float(cv2.Laplacian(grey, cv2.CV_64F).var())


def sharpness_among(
    files: Sequence[image_files.Image], longest: int, progress: Progress = in_silence
) -> Callable[[np.ndarray], np.ndarray]:
    """Return what measures (n,) of the files by their numbers: the variance of the Laplacian of
    grey images, all reduced alike, so that it is comparable within a call only; `longest` is their
    longer side in pixels, as their cameras state it."""

    def measure(frames: np.ndarray) -> np.ndarray:
        side = SHARPNESS_SIDE if len(frames) < MANY else SHARPNESS_SIDE // 2
        flag, some = GREY[image_files.reduction(longest, side)], [files[i] for i in frames]

        def of_file(at: int) -> float:
            return variance_of_laplacian(image_files.load(some[at], flag))

        return np.array(in_turn(of_file, some, progress))

    return measure


def thumbnails(files: Sequence[image_files.Image], longest: int, side: int) -> list[bytes | None]:
    """Return JPEG files whose longer side has `side` pixels or fewer; None for what is damaged."""

    def shrink(at: int) -> bytes | None:
        try:
            return jpeg(shrunk(files[at], longest, side))
        except ValueError:
            return None

    return in_turn(shrink, files)


def picture_side(count: int) -> int:
    """Return the longer side of each picture in pixels: many take no more room than few."""
    return max(LEAST, round(SIDE * min(1.0, np.sqrt(LARGE / count))))


def jpeg(image: np.ndarray, quality: int = 82) -> bytes:
    """A JPEG file of an (h, w, 3) RGB image in 0..255, by default as small as pages want it."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    return cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)[1].tobytes()


def shrunk(file: image_files.Image, longest: int, side: int) -> np.ndarray:
    """(h, w, 3) uint8 RGB image whose longer side has `side` pixels, or as many as it has."""
    flag = image_files.COLOR[image_files.reduction(longest, side)]
    return reduced(image_files.load(file, flag), side)


def reduced(image: np.ndarray, side: int) -> np.ndarray:
    """Return an (h, w, 3) uint8 image whose longer side has `side` pixels, or as many as it has."""
    scale = min(1.0, side / max(image.shape[:2]))
    size = tuple(max(1, round(n * scale)) for n in image.shape[1::-1])
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def check_pixels(files: Sequence[image_files.Image]) -> None:
    """Decode files to refuse one that no decoder takes; a video's frames are passed over."""
    in_turn(lambda at: image_files.check_pixels(files[at]), files)


def in_turn(
    work: Callable[[int], object],
    files: Sequence[image_files.Image],
    progress: Progress = in_silence,
) -> list:
    """Return the results of work on the number of every file, in order: by threads, since decoding
    leaves the interpreter's lock, but frames of a video one by one. An error ends the call after
    what is under way."""
    film = any(isinstance(file, image_files.VideoFrame) for file in files)
    each = map if film else side_by_side
    return list(progress(each(work, range(len(files))), len(files)))
