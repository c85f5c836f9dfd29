"""Order the searched subsets of all labelled scenes into trajectories."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.files import read_table, write_table
from fsel.geometry import pairwise_distances, pose_distance
from fsel.split import Split
from fsel.training.ordering import order_subset, trajectory_weights


def order(
    folders: Sequence[str | Path],
    splits: Sequence[str | Path],
    labels: Sequence[str | Path],
    trajectories: str | Path,
    *,
    scenes: Mapping[str, str],
    coverages: Sequence[int],
    kept: int,
    config: str,
) -> None:
    """Order the fittest subsets of every label item into trajectories (paper, Eq. 3 and 5).

    Args:
        folders: canonical captures, one a scene.
        splits: of all coverage levels, one a scene.
        labels: what `fsel.stages.label` wrote, one a coverage level of each scene.
        trajectories: receives one row a trajectory: scene, role, coverage, rank, fitness, weight,
            picks.
        scenes: scene -> role, `train` or `validation`.
        coverages: per cent.
        kept: subsets an item.
        config: digest of the parameters.
    """
    rows = []
    paths = iter(labels)
    for (scene, role), folder, path in zip(scenes.items(), folders, splits, strict=True):
        capture, table = Capture.load(folder), read_table(path)
        for coverage in coverages:
            split = Split.from_table(table[table["coverage"] == coverage])
            head = {"scene": scene, "role": role, "coverage": coverage}
            found = ordered_item(capture, split, read_table(next(paths)), kept)
            rows += [head | row for row in found]
    write_table(pd.DataFrame(rows), trajectories, units={"coverage": "percent"}, config=config)


def ordered_item(capture: Capture, split: Split, labels: pd.DataFrame, kept: int) -> list[dict]:
    """rank, fitness, weight and picks of the fittest subsets of one label item."""
    fittest = labels.query("0 <= rank < @kept").sort_values("rank")
    weights = trajectory_weights(fittest["fitness"].to_numpy())
    return [
        {
            "rank": row.rank,
            "fitness": row.fitness,
            "weight": weight,
            "picks": ordered(capture, split, np.array(row.subset)).tolist(),
        }
        for row, weight in zip(fittest.itertuples(), weights, strict=True)
    ]


def ordered(capture: Capture, split: Split, subset: np.ndarray) -> np.ndarray:
    """(K,) frames of the subset in the order that they best cover the proxies (Eq. 3)."""
    centers, axes = capture.centers[subset], capture.axes[subset]
    distances = pairwise_distances(centers, capture.centers[split.proxies])
    return subset[order_subset(distances, pose_distance(centers, axes, centers, axes))]
