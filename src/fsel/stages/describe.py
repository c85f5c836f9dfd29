"""Appearance and sharpness of a capture's frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.features.appearance import descriptors
from fsel.features.sharpness import sharpness
from fsel.files import write_table


def describe(
    folder: str | Path, output: str | Path, *, kind: str, weights: str | None, config: str
) -> None:
    """Appearance descriptor and sharpness of every frame of a capture, one row a frame."""
    capture = Capture.load(folder)
    table = pd.DataFrame({"frame": np.arange(len(capture)), "name": capture.names})
    table["sharpness"] = sharpness(capture.images)
    table["descriptor"] = list(descriptors(capture.images, kind, weights))
    units = {"sharpness": "squared grey levels", "descriptor": f"{kind}, unit vector"}
    write_table(table, output, units=units, config=config)
