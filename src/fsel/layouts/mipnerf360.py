"""Mip-NeRF 360: COLMAP at full resolution, images in folders by factor."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.layouts import colmap, images
from fsel.layouts.base import Layout, RawCapture
from fsel.recording import Recording

FACTOR = 4


def recognises(folder: Path) -> bool:
    """sparse/0 beside images_4 or images_2."""
    small = (folder / "images_4").is_dir() or (folder / "images_2").is_dir()
    return small and (folder / "sparse" / "0").is_dir()


def read(folder: Path) -> RawCapture:
    """The smallest copy that ships of images_4, images_2, images; sizes from the images."""
    model = folder / "sparse" / "0"
    for candidate in ("images_4", "images_2", "images"):
        if (folder / candidate).is_dir():
            return colmap.from_model(colmap.load_model(model), folder / candidate, model)
    raise FileNotFoundError(f"{folder}: none of images_4, images_2, images is there")


def write(recording: Recording, folder: Path) -> None:
    """images_4 and sparse/0, whose camera is four times as large."""
    names = [f"{name}.jpg" for name in recording.names]
    images.write(recording.images, folder / "images_4", names)
    camera = colmap.scaled(recording.camera, FACTOR)
    model = colmap.build_model(recording, camera, names, np.ones(len(names), bool))
    colmap.write_binary(model, folder / "sparse" / "0")


LAYOUT = Layout("mipnerf360", recognises, read, write)
