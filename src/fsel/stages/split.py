"""Targets, their proxies and the candidates: of every draw, or at every coverage level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import File, Files, repeated, stacked, write_table
from fsel.core.split import coverage_split, evaluation_split, partition


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


def split_labelled(
    folder: File, splits: File, *, coverages: Sequence[int], seed: int, config: str
) -> None:
    """Draw the targets of a scene that will be labelled at each of the coverages, in per cent.

    See the paper's Appendix A.2. `splits` receives `fsel.core.split.Split.table`, with the
    coverage.
    """
    capture = Capture.load(folder)
    parts = []
    for coverage in coverages:
        table = coverage_split(capture, coverage, seed).table(capture.names)
        parts.append(table | repeated({"coverage": coverage}, len(table["frame"])))
    write_table(stacked(parts), splits, units={"coverage": "percent"}, config=config)
