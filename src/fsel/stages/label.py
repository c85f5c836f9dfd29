"""Search for good subsets of a training scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import splits_in
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics, units
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import Journal
from fsel.training.labelling import searched
from fsel.utils.files import fingerprint, read_table, write_table

logger = logging.getLogger(__name__)


def label(
    folder: str | Path,
    splits: str | Path,
    labels: Sequence[str | Path],
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
        splits: what `fsel.stages.split_labelled` wrote.
        labels: one a coverage level: its subsets, see `fsel.training.labelling.search_table`.
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
    levels = {level["coverage"]: split for level, split in splits_in(read_table(splits))}
    with Journal(labels[-1], fingerprint(inputs, {"config": config})) as journal:
        for coverage, path in zip(coverages, labels, strict=True):
            split = levels[coverage]
            evaluator = Evaluator.on_frames(reconstructor, split.proxies, metrics=fitness)
            evaluate = journal.remember(f"p{coverage}", evaluator)
            problem = Problem.of(capture, split, described)
            table = searched(evaluate, problem, split, search, [seed, coverage], fitness)
            write_table(table, path, units=units(fitness), config=config)
            logger.info("p%d: %d subsets\n%s", coverage, len(table), table[table["rank"] == 0])
