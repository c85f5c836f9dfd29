"""Search for good subsets of a training scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import File, fingerprint, read_columns, write_table
from fsel.core.problem import Problem
from fsel.core.split import splits_in
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics, units
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import Journal
from fsel.training.search import search_table, searched

logger = logging.getLogger(__name__)


def label(
    folder: File,
    splits: File,
    labels: File,
    *,
    coverage: int,
    seed: int,
    search: Mapping,
    reconstruction: Mapping,
    fitness: Metrics,
    inputs: Iterable[File],
    config: str,
    library: str = "",
) -> None:
    """Label a training scene at one coverage level.

    Args:
        splits: what `split_labelled` wrote.
        labels: receives the subsets, see `fsel.training.search.search_table`.
        coverage: per cent.
        fitness: PSNR, SSIM and a perceptual distance of the registry, or name -> settings.
        inputs: files that the evaluations depend on; a change of one starts the search afresh.
    """
    capture = Capture.load(folder)
    (split,) = (s for level, s in splits_in(read_columns(splits)) if level["coverage"] == coverage)
    problem = Problem.of(capture, split, read_columns(Path(folder) / "descriptors.parquet"))
    reconstructor = reconstructor_of(capture, reconstruction)
    evaluator = Evaluator.on_frames(reconstructor, split.proxies, metrics=fitness)
    with Journal(labels, fingerprint(inputs, {"config": config, "library": library})) as journal:
        evaluate = journal.remember(f"p{coverage}", evaluator)
        result = searched(evaluate, problem, split, search, np.random.default_rng([seed, coverage]))
        table = search_table(result, search["stored"], fitness)
        write_table(table, labels, units=units(fitness), config=config)
    best = table["fitness"].max()
    logger.info("p%d: %d subsets, best fitness %.4f", coverage, len(table["rank"]), best)
