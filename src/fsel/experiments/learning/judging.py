"""Labelled subsets judged again, by another reconstructor than the one that the search asked."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import read_table, write_table
from fsel.reconstruct import reconstructor_of
from fsel.split import Split
from fsel.subsets import evenly

logger = logging.getLogger(__name__)

METRIC = ("psnr",)
KEPT = ["request", "k", "start", "begun", "rank", "psnr"]
UNITS = {"psnr": "dB", "psnr_again": "dB"}


def judge_requests(
    folder: str | Path,
    labels: str | Path,
    splits: str | Path,
    judged: str | Path,
    *,
    reconstruction: Mapping,
    subsets: int,
    config: str,
) -> None:
    """Judge a sample of every request's subsets again, on the same targets.

    Args:
        folder: a canonical capture.
        labels, splits: what `fsel.stages.label_requests` wrote of it.
        judged: receives request, k, start, begun (see `spread`), rank (of all labels of the
            request), psnr (the label) and psnr_again, one row a sampled subset, the best label of a
            request first.
        reconstruction: what judges, as the config's section.
        subsets: of a request, see `spread`.
        config: digest of the parameters.

    Raises:
        Unfinished: when a reconstruction does not finish.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    drawn, tables = read_table(splits), []
    for number, part in read_table(labels).groupby("request"):
        targets = Split.from_table(drawn[drawn["request"] == number]).targets
        evaluator = Evaluator.on_frames(reconstructor, targets, metrics=METRIC)
        chosen = spread(part, subsets)
        evaluator.measure_together(chosen["subset"].to_list())
        again = [float(evaluator(np.asarray(subset))[0]) for subset in chosen["subset"]]
        tables.append(chosen[KEPT].assign(psnr_again=again))
        logger.info("request %s: %d of %d subsets", number, len(chosen), len(part))
    write_table(pd.concat(tables), judged, units=UNITS, config=config)


def spread(part: pd.DataFrame, subsets: int) -> pd.DataFrame:
    """A sample of one request's subsets, the same in every run.

    Args:
        part: start, rank and further columns, one row a subset, in the order of evaluation.
        subsets: the most that are taken: the first of every kind of start, the others evenly
            spaced in rank, from the best to the worst.

    Returns:
        Rows of `part`, by rank, and begun: whether a subset is the first of its start, from which
        swaps began. Fewer than `subsets` where one is both.
    """
    begun = ~part["start"].duplicated()
    even = evenly(len(part), max(2, subsets - begun.sum()))
    return part.assign(begun=begun)[begun | part["rank"].isin(even)].sort_values("rank")
