"""Masks: white on black, named like the images."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from fsel.captures.images import files as image_files

MASKS = "masks"  # folder beside that of images that are placed
WHITE = 128  # least value of a mask's pixels that count
TINT = 32  # difference of a pixel's channels from which it is in colour: JPEG tints grey by less
COLOURED = 0.01  # share of such pixels from which an image is no mask


def mask_file(folder: Path, name: str) -> Path | None:
    """A frame's mask in a folder: `name.png`, or `name.jpg.png` as COLMAP has it; None without."""
    files = [folder / f"{name}.png", folder / Path(name).with_suffix(".png"), folder / name]
    return next((file for file in files if file.is_file()), None)


def load_white(file: Path) -> np.ndarray:
    """(h, w) bool, the white pixels of a mask; an image in colour is refused."""
    image = np.ascontiguousarray(image_files.load(file))
    channels = cv2.split(image)
    spread = np.maximum.reduce(channels) - np.minimum.reduce(channels)
    if (spread > TINT).mean() > COLOURED:
        raise ValueError(f"{file}: is a colour image, not a mask; allowed: white on black")
    return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) >= WHITE


def mask_of(folder: Path, name: str, image: image_files.Image) -> np.ndarray:
    """(h, w) bool mask of an image by its name; refused if missing or of another size."""
    file = mask_file(folder, name)
    if file is None:
        raise ValueError(
            f"{folder}: no mask for {name!r}. Hint: {Path(name).stem}.png, white on black"
        )
    white, size = load_white(file), image_files.size_of(image)
    if white.shape[::-1] != size:
        sizes = ["{}x{}".format(*one) for one in (white.shape[::-1], size)]
        raise ValueError(f"{file}: the mask has {sizes[0]} pixels, its image {sizes[1]}")
    return white
