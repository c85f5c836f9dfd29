"""Any layout into a canonical capture."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path

from fsel.captures.read import read_folder
from fsel.core.files import File

logger = logging.getLogger(__name__)


def ingest(source: File, folder: File, *, long_side: int, at_least: int, reading: Mapping) -> None:
    """Read a capture in its own layout and save its canonical form.

    Args:
        folder: receives frames.parquet, whose metadata say how well poses and images agree,
            points.parquet, images.npy and masks.npy, which is empty without masks.
        long_side: of the images stored, pixels.
        at_least: frames that the experiment needs: its targets, their proxies, the largest budget.
        reading: further keywords of `fsel.captures.read.read_folder`.

    Raises:
        ValueError: when the capture has fewer usable frames.
    """
    read = read_folder(source, long_side=long_side, store=Path(folder), **reading)
    capture = read.capture
    if len(capture) < at_least:
        raise ValueError(
            f"{source}: {len(capture)} usable frames, at least {at_least} are needed (targets, "
            "as many proxies, and the largest budget). Hint: record more frames, or lower "
            "`targets` or `budgets` in the config"
        )
    capture.save(folder, agreement=vars(read.agreement), dropped=read.dropped)
    logger.info("%s: %d frames at %s pixels", source, len(capture), capture.size)
