"""Labelled problems, read from what the workflow wrote."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import Columns, chosen, read_columns
from fsel.core.problem import Problem
from fsel.core.split import splits_in
from fsel.features.static import with_features

Scenes = Mapping[str, Sequence[str | Path]]
"""Scene -> the arguments of `read_problems`."""


def labelled_problems(
    trajectories: Columns, scenes: Scenes
) -> Iterator[tuple[Problem, list[dict[str, Any]]]]:
    """Yield the problem of every scene and coverage level, and its rows of the table that
    `fsel.stages.order` wrote, best first."""
    columns = (np.asarray(trajectories[name]).tolist() for name in trajectories)
    rows = [dict(zip(trajectories, row, strict=True)) for row in zip(*columns, strict=True)]
    rows.sort(key=itemgetter("scene", "coverage", "rank"))
    for scene, own in groupby(rows, itemgetter("scene")):
        problems = read_problems(*scenes[scene])
        for coverage, part in groupby(own, itemgetter("coverage")):
            yield problems[coverage], list(part)


def read_problems(
    folder: str | Path, splits: str | Path, features: str | Path | None = None
) -> dict[int, Problem]:
    """Read the problems of a labelled scene, a described canonical capture, by coverage in per
    cent; without `features`, whoever reads them computes them."""
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
