"""The targets of every draw, their proxies and the candidates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_table
from fsel.core.split import evaluation_split, partition


def split(
    folder: File,
    splits: Files,
    *,
    targets: int,
    seed: int,
    hold_out: Mapping | None = None,
    config: str,
) -> None:
    """Draw the targets of a capture, or hold out frames.

    Args:
        splits: one a draw, see `fsel.core.split.Split.table`.
        hold_out: the config's section, whose `every` holds out each so manieth frame.
    """
    capture = Capture.load(folder)
    for draw, output in enumerate(splits):
        every = np.arange(len(capture))
        if hold_out and hold_out["every"]:
            made = partition(capture, every[:: hold_out["every"]], every)
        else:
            made = evaluation_split(capture, draw, seed, targets)
        write_table(made.table(capture.names), output, units={}, config=config)
