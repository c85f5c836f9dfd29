"""Reconstruct a capture from every selection, and compare with held-out targets."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import File, Files, chosen, read_columns, write_table
from fsel.core.split import Split
from fsel.evaluation import measuring
from fsel.evaluation.evaluator import evaluators
from fsel.metrics import Metrics

logger = logging.getLogger(__name__)


def evaluate(
    folder: File,
    splits: Files,
    selections: Files,
    evaluations: Files,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    only: Mapping[str, Sequence] | None = None,
    config: str,
) -> None:
    """Reconstruct every selection and compare it with the held-out targets of its draw.

    The draws share one reconstructor, and with it the matching costs that they have in common.

    Args:
        selections: what `select` wrote, one a draw.
        evaluations: one a draw, see `fsel.evaluation.measuring.measure`.
        only: column -> values of the picks that are reconstructed; all without it.
    """
    units = measuring.measured_units(metrics)
    capture, evaluator = Capture.load(folder), evaluators(reconstruction, metrics)
    for split, picked, path in zip(splits, selections, evaluations, strict=True):
        logger.info("%s", picked)
        targets = Split.load(split).targets
        picks = read_columns(picked)
        for column, values in (only or {}).items():
            picks = chosen(picks, np.isin(picks[column], values))
        table = measuring.measure(evaluator(capture, targets), picks)
        write_table(table, path, units=units, config=config)
