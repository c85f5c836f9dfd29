"""The features of every candidate that no selection changes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fsel.features.columns import STATIC
from fsel.features.static import UNITS, static_features
from fsel.files import write_table
from fsel.problem import Problem


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
        names, rows = problem.capture.names, problem.candidates
        values = static_features(problem, rows, problem.capture.view(problem.proxies))
        columns = {"frame": rows, "name": [names[frame] for frame in rows]}
        columns |= dict(zip(STATIC, values.T, strict=True))
        write_table(columns, path, units=UNITS, config=config)
