"""Picks of several draws of targets, measured each on its own."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import pandas as pd

from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import measure
from fsel.reconstruct import Reconstructor
from fsel.utils.files import Files

logger = logging.getLogger(__name__)


def measure_draws(
    reconstructor: Reconstructor, splits: Files, picks: pd.DataFrame, by: Sequence[str]
) -> pd.DataFrame:
    """Measure picks on the targets of their draws.

    Args:
        reconstructor: bound to the capture.
        picks: `draw`, `frame`, and the columns of `by`.
        by: see `fsel.evaluation.measuring.measure`; `draw` is one of them.

    Returns:
        As `fsel.evaluation.measuring.measure`.
    """
    tables = []
    for draw, part in picks.groupby("draw"):
        targets = Split.load(splits[int(draw)]).targets
        tables.append(measure(Evaluator.on_frames(reconstructor, targets), part, by))
        logger.info("draw %d: %.2f dB", draw, tables[-1]["psnr"].mean())
    return pd.concat(tables)
