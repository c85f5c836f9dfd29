"""Appearance and sharpness of a capture's frames."""

from __future__ import annotations

import numpy as np

from fsel.captures.images.previews import sharpness
from fsel.core.capture import Capture
from fsel.core.files import File, write_table
from fsel.features import appearance


def describe(
    folder: File, descriptors: File, *, kind: str, weights: str | None, config: str
) -> None:
    """Compute appearance descriptor and sharpness of every frame of a capture.

    Args:
        descriptors: receives frame, name, sharpness and descriptor, one row a frame.
        kind, weights: see `fsel.features.appearance.descriptors`.
    """
    capture = Capture.load(folder)
    table = {
        "frame": np.arange(len(capture)),
        "name": capture.names,
        "sharpness": sharpness(capture.images),
        "descriptor": appearance.descriptors(capture.images, kind, weights),
    }
    units = {"sharpness": "squared grey levels", "descriptor": f"{kind}, unit vector"}
    write_table(table, descriptors, units=units, config=config)
