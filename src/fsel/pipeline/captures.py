"""Embedded captures onto disk, any layout into a canonical capture, descriptors of its frames."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.appearance import descriptors
from fsel.capture import Capture
from fsel.layouts import LAYOUTS, read_folder
from fsel.pipeline.files import write_table
from fsel.sharpness import sharpness
from fsel.synthesis import record

logger = logging.getLogger(__name__)


def generate(
    folder: str | Path, *, layout: str, family: str, seed: int, frames: int, width: int, height: int
) -> None:
    """Ray-cast an embedded capture and write it as its dataset's owners would.

    Args:
        folder: where to; what is there is replaced.
        layout: key of `fsel.layouts.LAYOUTS`.
        family: one of `fsel.synthesis.FAMILIES`.
        seed: of the scene.
        frames: how many.
        width: pixels.
        height: pixels.
    """
    folder = Path(folder)
    if folder.exists():
        shutil.rmtree(folder)
    recording = record(family, seed, frames=frames, width=width, height=height)
    folder.mkdir(parents=True)
    LAYOUTS[layout].write(recording, folder)
    logger.info("%s: %d frames of family %s as %s", folder, frames, family, layout)


def ingest(source: str | Path, folder: str | Path, *, at_least: int, **reading) -> None:
    """Read a capture in its own layout and save its canonical form.

    Args:
        source: folder as the dataset distributes it.
        folder: receives frames.parquet, whose metadata say how well poses and images agree,
            points.parquet, images.npy and, of captures with masks, masks.npy.
        at_least: frames that the experiment needs: its targets, their proxies, the largest budget.
        reading: further keywords of `fsel.layouts.read_folder`.

    Raises:
        ValueError: when the capture has fewer usable frames.
    """
    found = read_folder(source, store=Path(folder), **reading)
    capture = found.capture
    if len(capture) < at_least:
        raise ValueError(
            f"{source}: {len(capture)} usable frames, at least {at_least} are needed (targets, "
            "as many proxies, and the largest budget). Hint: record more frames, or lower "
            "`targets` or `budgets` in the config"
        )
    capture.save(folder, agreement=vars(found.agreement), dropped=found.dropped)
    logger.info("%s: %d frames at %s pixels", source, len(capture), capture.size)


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
