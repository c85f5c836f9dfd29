"""Search for good subsets of a training scene's requests, among all observed frames."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import fingerprint, read_table, write_table
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import Journal
from fsel.training.requests import (
    Judge,
    most_subsets,
    requests_of,
    search_request,
    seconds_each,
)

logger = logging.getLogger(__name__)

METRIC = ("psnr",)
UNITS = {"coverage": "percent", "psnr": "dB"}


def label_requests(
    folder: str | Path,
    labels: str | Path,
    splits: str | Path,
    *,
    coverages: Sequence[int],
    draws: int,
    budgets: Sequence[int],
    search: Mapping,
    seed: int,
    reconstruction: Mapping,
    inputs: Iterable[str | Path],
    config: str,
) -> None:
    """Label one training scene's requests, sharing one reconstructor.

    Args:
        folder: a canonical capture with its descriptors.
        labels: receives request, coverage, draw, k, and the columns of `search_request`.
        splits: receives the split of every request.
        coverages: per cent.
        draws: of targets at every coverage level.
        budgets: that a request's number of frames is drawn from.
        search: evaluations, exchanged, generations; see `search_request`.
        seed: of the scene.
        reconstruction: the config's section.
        inputs: files that the evaluations depend on; a change of one starts the search afresh.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    asked = requests_of(coverages, draws, budgets, seed)
    tables, parts = [], []
    with Journal(labels, fingerprint(inputs, {"config": config})) as journal:
        for number, request in enumerate(asked):
            split = request.split(capture, seed)
            problem = Problem.of(capture, split, described)
            evaluator = Evaluator.on_frames(reconstructor, split.targets, metrics=METRIC)
            if number == 0:
                _say_the_cost(evaluator, problem, budgets, len(asked) * most_subsets(search))
                logger.info("%d subsets are known", journal.known)
            judge = _psnr(journal.remember(number, evaluator))
            rng = np.random.default_rng([seed, number])
            found = search_request(judge, problem, request.k, search, rng)
            tables.append(found.assign(request=number, **asdict(request)))
            parts.append(split.table(capture.names).assign(request=number))
            first, best = found["psnr"].iloc[0], found["psnr"].max()
            text = "%d of %d: %s, %d subsets: the rule %.2f dB, the best %+.2f dB"
            logger.info(text, number + 1, len(asked), request, len(found), first, best - first)
        write_table(pd.concat(tables), labels, units=UNITS, config=config)
        write_table(pd.concat(parts), splits, units={}, config=config)


def _say_the_cost(
    evaluator: Evaluator, problem: Problem, budgets: Sequence[int], subsets: int
) -> None:
    """Log how many subsets will be reconstructed, and how long that takes at most."""
    each = seconds_each(_psnr(evaluator), problem.observed, int(np.mean(budgets)))
    text = "at most %d subsets of %d..%d frames, at most about %.0f s"
    logger.info(text, subsets, min(budgets), max(budgets), each * subsets)


def _psnr(evaluate: Callable[[np.ndarray], np.ndarray]) -> Judge:
    return lambda subset: float(evaluate(subset)[0])
