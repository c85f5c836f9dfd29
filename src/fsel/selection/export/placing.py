"""Images and masks of a subset, put where trainers look for them."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.undistortion import Lens, is_straight
from fsel.captures.images import files as image_files
from fsel.captures.images.masks import load_white, mask_file
from fsel.captures.layouts.contract import RawCapture

FILM = ".jpg"  # ending of images that are frames of a video
WRITABLE = (".png", ".jpg", ".jpeg")  # what is changed into another file of its kind


def file_name(raw: RawCapture, frame: int, changed: bool) -> str:
    """Name of the frame's image below `images`, with the ending that its file has."""
    name, file = raw.names[frame], raw.images[frame]
    ending = FILM if isinstance(file, image_files.VideoFrame) else file.suffix
    if changed and ending.lower() not in WRITABLE:
        ending = ".png"
    return name if Path(name).suffix.lower() == ending.lower() else f"{name}{ending}"


def inside(folder: Path, name: str) -> Path:
    """The path of a name below a folder; a name that leads out of it is refused."""
    path = Path(os.path.normpath(folder / name))
    if not path.is_relative_to(folder):
        raise ValueError(f"frame {name!r}: its name leads outside the output folder")
    return path


def place(
    file: image_files.Image,
    path: Path,
    link: bool,
    size: tuple[int, int] | None,
    lens: Lens | None = None,
) -> None:
    """Put an image at a path, as a hard link where it may be and the file system has them.

    A photo whose EXIF asks for a turn is encoded again without that word: cameras describe the
    pixels as they are stored, and some trainers would turn them.

    Args:
        size: (width, height) that it is reduced to; None as it is.
        lens: undistorts it to that size; None to keep its distortion.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if size is not None or isinstance(file, image_files.VideoFrame):
        image = np.ascontiguousarray(image_files.load(file))
        image = image if lens is None else lens.straighten(image)
        if size is not None and image.shape[1::-1] != size:
            image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        image_files.write(image[None], path.parent, [path.name])
        return
    if image_files.orientation(file) != 1:
        image_files.write_photo(file, path, upright=False)
        return
    if link:
        try:
            os.link(file.resolve(), path)
            return
        except OSError:
            pass  # another file system, or one without hard links
    shutil.copy2(file, path)


def mask(
    raw: RawCapture, frame: int, shapes: Path | None, size: tuple[int, int], undistort: bool
) -> np.ndarray:
    """(h, w) uint8 0 or 255 at (width, height) `size`: of the object, else the capture's own."""
    white = np.zeros(size[::-1], bool)
    if shapes is not None:
        file = mask_file(shapes, raw.names[frame])
        white = load_white(file) if file else white
    elif raw.masks is not None:
        white = image_files.load_mask(raw.masks[frame], raw.mask_values)
    if undistort and not is_straight(raw.cameras[frame]):
        lens = Lens(raw.cameras[frame], white.shape[::-1], max(white.shape))
        white = lens.straighten_mask(white)
    return cv2.resize(white.astype(np.uint8) * 255, size, interpolation=cv2.INTER_NEAREST_EXACT)
