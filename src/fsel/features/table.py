"""The static features of a problem as a table: `features.parquet`, written once and read after."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.files import Columns
from fsel.core.problem import Problem
from fsel.features.columns import STATIC
from fsel.features.static import static_features


def features_table(problem: Problem) -> dict[str, Any]:
    """Describe every candidate by what no pick changes (paper, section 3.2), unstandardised.

    Returns:
        One row a candidate, ascending: frame, name, and the 14 columns
        `fsel.features.columns.STATIC` as float64. Units are `fsel.features.static.UNITS`.
    """
    names = [problem.capture.names[frame] for frame in problem.candidates]
    references = problem.capture.view(problem.proxies)
    values = static_features(problem, problem.candidates, references)
    return {"frame": problem.candidates, "name": names, **dict(zip(STATIC, values.T, strict=True))}


def with_features(problem: Problem, table: Columns, source: str | Path) -> Problem:
    """Return the problem with the features that `features_table` wrote down for it.

    Args:
        problem: the selection problem.
        table: its rows in any order.
        source: the file they were read from, for error messages.

    Raises:
        ValueError: for rows that are not the problem's candidates, one each, or values that are
            missing or not finite.
    """
    lacking = [name for name in ("frame", *STATIC) if name not in table]
    if lacking:
        raise ValueError(f"{source}: no column {', '.join(lacking)}; has {', '.join(table)}")
    order = np.argsort(table["frame"])
    frames = np.asarray(table["frame"])[order]
    if not np.array_equal(frames, problem.candidates):
        wrong = np.setxor1d(frames, problem.candidates)
        raise ValueError(
            f"{source}: {len(frames)} rows are not one for each of the problem's "
            f"{len(problem.candidates)} candidates (frames {wrong[:5].tolist()} differ). Hint: it "
            "was made for another split; make it anew"
        )
    # rows one after another, as they were computed: another order would sum in another order
    values = np.ascontiguousarray(np.array([table[name] for name in STATIC], np.float64).T[order])
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise ValueError(
            f"{source}: {STATIC[column]} of frame {frames[row]} is {values[row, column]}; allowed: "
            "finite numbers"
        )
    return replace(problem, features=values)
