"""Tanks and Temples, the 3DGS release: the model's camera is twice the images' size."""

from __future__ import annotations

from pathlib import Path

from fsel.layouts import colmap, images
from fsel.layouts.base import Layout
from fsel.recording import Recording

FACTOR = 2


def write(recording: Recording, folder: Path) -> None:
    """images/ at half size, sparse/0; frames whose pose was lost are absent from the model."""
    names = [f"{name}.jpg" for name in recording.names]
    images.write(recording.images, folder / "images", names)
    camera = colmap.scaled(recording.camera, FACTOR)
    model = colmap.build_model(recording, camera, names, ~recording.lost)
    colmap.write_binary(model, folder / "sparse" / "0")


LAYOUT = Layout("tanks_and_temples", lambda folder: False, colmap.read, write)
"""Recognised as plain COLMAP, whose reader serves it."""
