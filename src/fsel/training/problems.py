"""Problems of labelled scenes, read from what the workflow wrote."""

from __future__ import annotations

from pathlib import Path

from fsel.core.capture import Capture
from fsel.core.columns import chosen
from fsel.core.files import read_columns
from fsel.core.problem import Problem
from fsel.core.split import splits_in
from fsel.features.table import with_features


def read_problems(
    folder: str | Path, splits: str | Path, features: str | Path | None = None
) -> dict[int, Problem]:
    """Read the problems of a labelled scene, each file once for all coverage levels.

    Args:
        folder: a canonical capture with its descriptors.
        splits: what `fsel.stages.split_labelled` wrote.
        features: what `fsel.stages.features` wrote of them; None leaves them to whoever reads them.

    Returns:
        Coverage in per cent -> problem, ascending.

    Raises:
        ValueError: for features of other candidates than the split's.
    """
    capture = Capture.load(folder)
    described = read_columns(Path(folder) / "descriptors.parquet")
    problems = {
        level["coverage"]: Problem.of(capture, split, described)
        for level, split in splits_in(read_columns(splits))
    }
    if features is None:
        return problems
    table = read_columns(features)
    return {
        coverage: with_features(problem, chosen(table, table["coverage"] == coverage), features)
        for coverage, problem in problems.items()
    }
