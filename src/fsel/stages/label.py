"""Search for good subsets of a training scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import coverage_split
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics, units
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import Journal
from fsel.training.labelling import search_subsets, search_table
from fsel.utils.files import fingerprint, read_table, write_table

logger = logging.getLogger(__name__)


def label(
    folder: str | Path,
    labels: Sequence[str | Path],
    splits: str | Path,
    *,
    coverages: Sequence[int],
    seed: int,
    search: Mapping,
    reconstruction: Mapping,
    fitness: Metrics,
    inputs: Iterable[str | Path],
    config: str,
) -> None:
    """Label one training scene at every coverage level, sharing one reconstructor.

    Args:
        folder: a canonical capture with its descriptors.
        labels: one a coverage level: its subsets, see `search_table`.
        splits: receives the splits of all levels.
        coverages: per cent.
        seed: of the scene.
        search, reconstruction: the config's sections.
        fitness: PSNR, SSIM and a perceptual distance of the registry, or name -> settings.
        inputs: files that the evaluations depend on; a change of one starts the search afresh.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    parts = []
    with Journal(splits, fingerprint(inputs, {"config": config})) as journal:
        for coverage, path in zip(coverages, labels, strict=True):
            split = coverage_split(capture, coverage, seed)
            evaluator = Evaluator.on_frames(reconstructor, split.proxies, metrics=fitness)
            evaluate = journal.remember(f"p{coverage}", evaluator)
            problem = Problem.of(capture, split, described)
            rng = np.random.default_rng([seed, coverage])
            result = search_subsets(evaluate, problem, split, search["labeller"], search, rng)
            table = search_table(result, search["stored"], fitness)
            write_table(table, path, units=units(fitness), config=config)
            parts.append(split.table(capture.names).assign(coverage=coverage))
            logger.info("p%d: %d subsets\n%s", coverage, len(table), table[table["rank"] == 0])
        write_table(pd.concat(parts), splits, units={"coverage": "percent"}, config=config)
