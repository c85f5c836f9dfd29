"""Search for good subsets of a training scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import File, Files, fingerprint, read_columns, write_table
from fsel.core.problem import Problem
from fsel.core.split import splits_in
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics, units
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import EvaluationLimitReached, Journal
from fsel.training.labelling import searched

logger = logging.getLogger(__name__)


def label(
    folder: File,
    splits: File,
    labels: Files,
    *,
    coverages: Sequence[int],
    seed: int,
    search: Mapping,
    reconstruction: Mapping,
    fitness: Metrics,
    inputs: Iterable[File],
    config: str,
    known: File | Files = (),
) -> None:
    """Label one training scene at every coverage level, sharing one reconstructor.

    Args:
        splits: what `fsel.stages.split_labelled` wrote.
        labels: one a coverage level: its subsets, see `fsel.training.labelling.search_table`.
        coverages: per cent.
        fitness: PSNR, SSIM and a perceptual distance of the registry, or name -> settings.
        inputs: files that the evaluations depend on; a change of one starts the search afresh.
        known: what the last `label_part` wrote, where the scene is labelled by several jobs.
    """
    key = fingerprint(inputs, {"config": config})
    with Journal(labels[-1], key, known) as journal:
        work = Searches(journal, folder, splits, search, reconstruction, fitness, seed)
        for coverage, path in zip(coverages, labels, strict=True):
            table = work.table(coverage)
            write_table(table, path, units=units(fitness), config=config)
            best = table["fitness"].max()
            logger.info("p%d: %d subsets, best fitness %.4f", coverage, len(table["rank"]), best)


def label_part(
    folder: File,
    splits: File,
    evaluated: File,
    *,
    coverages: Sequence[int],
    seed: int,
    search: Mapping,
    reconstruction: Mapping,
    fitness: Metrics,
    most: int,
    inputs: Iterable[File],
    config: str,
    known: File | Files = (),
) -> None:
    """Make a share of the evaluations that labelling a scene takes, for `label` to go on from.

    Args:
        evaluated: receives all evaluations so far.
        most: evaluations of this job.
        known: what the part before wrote; nothing for the first.
        folder, splits, coverages, seed, search, reconstruction, fitness, inputs, config: as of
            `label`.
    """
    key = fingerprint(inputs, {"config": config})
    with Journal(evaluated, key, known, most) as journal:
        work = Searches(journal, folder, splits, search, reconstruction, fitness, seed)
        with suppress(EvaluationLimitReached):
            for coverage in coverages:
                work.table(coverage)
        journal.copy(evaluated)


class Searches:
    """Searches of one scene, whose evaluations go by a journal; arguments as of `label`."""

    def __init__(
        self,
        journal: Journal,
        folder: File,
        splits: File,
        search: Mapping,
        reconstruction: Mapping,
        fitness: Metrics,
        seed: int,
    ) -> None:
        self.journal, self.search, self.fitness, self.seed = journal, search, fitness, seed
        self.capture = Capture.load(folder)
        self.described = read_columns(Path(folder) / "descriptors.parquet")
        self.reconstructor = reconstructor_of(self.capture, reconstruction)
        read = splits_in(read_columns(splits))
        self.levels = {level["coverage"]: split for level, split in read}

    def table(self, coverage: int) -> dict[str, np.ndarray]:
        """The searched subsets at a coverage level, see `fsel.training.labelling.search_table`."""
        split = self.levels[coverage]
        evaluator = Evaluator.on_frames(self.reconstructor, split.proxies, metrics=self.fitness)
        evaluate = self.journal.remember(f"p{coverage}", evaluator)
        problem = Problem.of(self.capture, split, self.described)
        seeds = [self.seed, coverage]
        return searched(evaluate, problem, split, self.search, seeds, self.fitness)
