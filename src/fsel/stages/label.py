"""Search for good subsets of training scenes, and order them into trajectories."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import fingerprint, write_table
from fsel.geometry import pairwise_distances, pose_distance
from fsel.metrics import METRIC_UNITS
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.split import Split, coverage_split
from fsel.training.journal import Journal
from fsel.training.labelling import search_subsets, search_table
from fsel.training.ordering import order_subset, trajectory_weights

logger = logging.getLogger(__name__)


def label(
    folder: str | Path,
    outputs: Mapping[int, str | Path],
    splits: str | Path,
    *,
    seed: int,
    search: Mapping,
    reconstruction: Mapping,
    inputs: Iterable[str | Path],
    config: str,
) -> None:
    """Label one training scene at every coverage level, sharing one reconstructor.

    Args:
        folder: a canonical capture with its descriptors.
        outputs: coverage level -> the path of its subsets.
        splits: path of the table of all levels' splits.
        seed: of the scene.
        search, reconstruction: the config's sections.
        inputs: files that the evaluations depend on; a change of one starts the search afresh.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = pd.read_parquet(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    parts = []
    with Journal(splits, fingerprint(inputs, {"config": config})) as journal:
        for coverage, output in outputs.items():
            split = coverage_split(capture, coverage, seed)
            evaluator = Evaluator.on_frames(reconstructor, split.proxies)
            evaluate = journal.remember(f"p{coverage}", evaluator)
            problem = Problem.of(capture, split, described)
            rng = np.random.default_rng([seed, coverage])
            result = search_subsets(evaluate, problem, split, search["labeller"], search, rng)
            table = search_table(result, search["stored"])
            write_table(table, output, units=METRIC_UNITS, config=config)
            parts.append(split.table(capture.names).assign(coverage=coverage))
            logger.info("p%d: %d subsets\n%s", coverage, len(table), table[table["rank"] == 0])
        write_table(pd.concat(parts), splits, units={"coverage": "percent"}, config=config)


def trajectories(scenes: Sequence[Mapping], output: str | Path, *, kept: int, config: str) -> None:
    """Order the fittest subsets of every label item into trajectories (paper, Eq. 3 and 5).

    Args:
        scenes: one mapping a scene: `scene`, `role`, `folder`, `splits`, `labels` (coverage ->
            path).
        output: one row a trajectory: scene, role, coverage, rank, fitness, weight, picks.
        kept: subsets an item.
        config: digest of the parameters.
    """
    rows = []
    for item in scenes:
        capture = Capture.load(item["folder"])
        splits = pd.read_parquet(item["splits"])
        for coverage, path in item["labels"].items():
            split = Split.from_table(splits[splits["coverage"] == coverage])
            labelled = pd.read_parquet(path).query("0 <= rank < @kept").sort_values("rank")
            weights = trajectory_weights(labelled["fitness"].to_numpy())
            for row, weight in zip(labelled.itertuples(), weights, strict=True):
                rows.append(
                    {
                        "scene": item["scene"],
                        "role": item["role"],
                        "coverage": coverage,
                        "rank": row.rank,
                        "fitness": row.fitness,
                        "weight": weight,
                        "picks": ordered(capture, split, np.array(row.subset)).tolist(),
                    }
                )
    write_table(pd.DataFrame(rows), output, units={"coverage": "percent"}, config=config)


def ordered(capture: Capture, split: Split, subset: np.ndarray) -> np.ndarray:
    """(K,) frames of the subset in the order that they best cover the proxies (Eq. 3)."""
    centers, axes = capture.centers[subset], capture.axes[subset]
    distances = pairwise_distances(centers, capture.centers[split.proxies])
    return subset[order_subset(distances, pose_distance(centers, axes, centers, axes))]
