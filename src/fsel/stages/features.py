"""The features of every candidate that no selection changes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from fsel.data.problem import Problem
from fsel.features.columns import STATIC
from fsel.features.static import UNITS, static_features
from fsel.utils.files import write_table


def features(
    folder: str | Path,
    splits: Sequence[str | Path],
    tables: Sequence[str | Path],
    *,
    config: str,
) -> None:
    """Raw features of every candidate of each draw against its proxies (paper, section 3.2).

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        tables: one a draw: frame, name, and the columns of `fsel.features.static.STATIC`.
        config: digest of the parameters.
    """
    for split, path in zip(splits, tables, strict=True):
        problem = Problem.load(folder, split)
        names = problem.capture.names
        table = pd.DataFrame({"frame": problem.candidates})
        table["name"] = [names[frame] for frame in problem.candidates]
        table[list(STATIC)] = static_features(
            problem, problem.candidates, problem.capture.view(problem.proxies)
        )
        write_table(table, path, units=UNITS, config=config)
