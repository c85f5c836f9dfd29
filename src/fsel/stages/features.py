"""The features of every candidate that no selection changes."""

from __future__ import annotations

from pathlib import Path

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_columns, repeated, stacked, write_table
from fsel.core.problem import Problem
from fsel.core.split import splits_in
from fsel.features.static import UNITS, features_table


def features(folder: File, splits: Files, tables: Files, *, config: str) -> None:
    """Compute the static features of every candidate against its proxies (paper, section 3.2).

    Args:
        splits: split.parquet of a draw, or splits.parquet of all coverage levels.
        tables: one for each of the splits, see `fsel.features.static.features_table`; with a column
            `coverage` where its split has one.
    """
    capture = Capture.load(folder)
    described = read_columns(Path(folder) / "descriptors.parquet")
    for path, table in zip(splits, tables, strict=True):
        parts = [
            features_table(Problem.of(capture, split, described))
            | repeated(level, len(split.candidates))
            for level, split in splits_in(read_columns(path))
        ]
        write_table(stacked(parts), table, units=UNITS, config=config)
