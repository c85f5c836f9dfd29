"""Search for good subsets of training scenes, and order them into trajectories."""

from __future__ import annotations

import logging
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines.nearest import nearest
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import fingerprint, subsets_column, write_table
from fsel.geometry import pairwise_distances, pose_distance
from fsel.metrics import METRICS
from fsel.problem import Problem
from fsel.reconstruct import RECONSTRUCTORS, Reconstructor
from fsel.split import Split, coverage_split
from fsel.stages.journal import Journal
from fsel.stages.split import problem_of, split_from, split_table
from fsel.training.ordering import order_subset, trajectory_weights
from fsel.training.search import (
    Evaluate,
    GeneticSettings,
    SearchResult,
    genetic_search,
    random_search,
    swap_search,
)

logger = logging.getLogger(__name__)

METRIC_UNITS = {"psnr": "dB"}
GENETIC = (
    "population",
    "farthest",
    "uniform",
    "generations",
    "elites",
    "tournament",
    "crossover",
    "mutation",
)


def reconstructor_of(capture: Capture, reconstruction: Mapping) -> Reconstructor:
    """The configured reconstructor, bound to the capture at the reconstruction's size."""
    factory = RECONSTRUCTORS[reconstruction["name"]]
    resized = capture.resized(reconstruction["long_side"])
    return factory(resized, **reconstruction["settings"])


def search_subsets(
    evaluate: Evaluate,
    problem: Problem,
    split: Split,
    labeller: str,
    search: Mapping,
    rng: np.random.Generator,
) -> SearchResult:
    """Search the candidates for subsets of search["k"] frames.

    Args:
        evaluate: (K,) frames -> (3,) metrics on the proxies.
        problem: the selection problem.
        split: of the problem; its region feeds the genetic search's first population.
        labeller: `genetic` (the paper's), `swap` (hill climbing from the nearest frames) or
            `random`.
        search: the config's section of that name.
        rng: the only source of chance.
    """
    pool, k = split.candidates, search["k"]
    if labeller == "random":
        return random_search(evaluate, pool, k, search["evaluations"], rng)
    if labeller == "swap":
        starts = [nearest(problem, pool, k)]
        return swap_search(evaluate, pool, starts, search["evaluations"], rng)
    settings = GeneticSettings(**{key: search[key] for key in GENETIC})
    return genetic_search(evaluate, pool, split.region, problem.capture.centers, k, rng, settings)


def search_table(result: SearchResult, stored: int) -> pd.DataFrame:
    """One row a distinct subset, in the order of evaluation; `rank` 0 is the fittest.

    `rank` is -1 beyond the `stored` fittest.
    """
    table = pd.DataFrame({"generation": result.generation})
    table["subset"] = subsets_column(result.subsets)
    table[list(METRICS)] = result.metrics
    table["fitness"] = result.fitness
    table["rank"] = -1
    table.loc[result.best(stored), "rank"] = np.arange(min(stored, len(table)))
    return table


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
            problem = problem_of(capture, split, described)
            rng = np.random.default_rng([seed, coverage])
            result = search_subsets(evaluate, problem, split, search["labeller"], search, rng)
            table = search_table(result, search["stored"])
            write_table(table, output, units=METRIC_UNITS, config=config)
            parts.append(split_table(split, capture.names).assign(coverage=coverage))
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
            split = split_from(splits[splits["coverage"] == coverage])
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


def name_seed(*parts: object) -> int:
    """A seed from names and numbers, the same on every machine."""
    return zlib.crc32("/".join(map(str, parts)).encode())
