"""Reconstruct a capture from every selection, and compare with held-out targets."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from fsel.data.capture import Capture
from fsel.data.split import Split
from fsel.evaluation import measuring
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics
from fsel.reconstruct import reconstructor_of
from fsel.utils.files import File, Files, read_table, write_table

logger = logging.getLogger(__name__)


def evaluate(
    folder: File,
    splits: Files,
    selections: Files,
    evaluations: Files,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    config: str,
) -> None:
    """Reconstruct every selection and compare it with the held-out targets of its draw.

    The draws share one reconstructor, and with it the matching costs that they have in common.

    Args:
        selections: what `select` wrote, one a draw.
        evaluations: one a draw, see `fsel.evaluation.measuring.measure`.
    """
    units = measuring.measured_units(metrics)
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    for split, picked, path in zip(splits, selections, evaluations, strict=True):
        logger.info("%s", picked)
        targets = Split.load(split).targets
        evaluator = Evaluator.on_frames(reconstructor, targets, metrics=metrics)
        table = measuring.measure(evaluator, read_table(picked))
        write_table(table, path, units=units, config=config)
