"""Embedded captures onto disk, as their datasets are distributed."""

from __future__ import annotations

import logging
from pathlib import Path

from fsel.captures.layouts import LAYOUTS
from fsel.core.files import File
from fsel.core.outputs import staged
from fsel.synthetic import record

logger = logging.getLogger(__name__)


def generate(
    folder: File, *, layout: str, family: str, seed: int, frames: int, width: int, height: int
) -> None:
    """Ray-cast an embedded capture and write it as its dataset's owners would.

    Args:
        folder: where to; what an earlier run wrote there is replaced.
        layout: key of `fsel.captures.layouts.LAYOUTS`.
        family: one of `fsel.synthetic.FAMILIES`.
        frames: how many; width, height: pixels.

    Raises:
        ValueError: for a layout that is only read.
    """
    write = LAYOUTS[layout].write
    if write is None:
        raise ValueError(f"layout is {layout!r}, which is read-only; {folder} cannot be written")
    folder = Path(folder)
    recording = record(family, seed, frames=frames, width=width, height=height)
    with staged(folder, [], force=True) as made:
        write(recording, made)
    logger.info("%s: %d frames of family %s as %s", folder, frames, family, layout)
