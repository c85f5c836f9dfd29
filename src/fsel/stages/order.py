"""Order the searched subsets of all labelled scenes into trajectories."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.data.capture import Capture
from fsel.data.split import Split
from fsel.training.ordering import ordered_item
from fsel.utils.files import read_table, write_table


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
