"""Labelled problems and their trajectories, read from what the workflow wrote."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import splits_in
from fsel.features.table import with_features
from fsel.selector.policies import Policy
from fsel.selector.rollout import Rollout, follow
from fsel.training.imitation import Trajectory
from fsel.utils.files import read_table

Scenes = Mapping[str, Sequence[str | Path]]
"""Scene -> the arguments of `read_problems`."""


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
    described = read_table(Path(folder) / "descriptors.parquet")
    problems = {
        level["coverage"]: Problem.of(capture, split, described)
        for level, split in splits_in(read_table(splits))
    }
    if features is None:
        return problems
    table = read_table(features)
    return {
        coverage: with_features(problem, table[table["coverage"] == coverage], features)
        for coverage, problem in problems.items()
    }


def labelled_problems(
    trajectories: pd.DataFrame, scenes: Scenes
) -> Iterator[tuple[Problem, pd.DataFrame]]:
    """Yield the problem of every scene and coverage level, and its rows of the table, best first.

    Args:
        trajectories: what `fsel.stages.order` wrote.
        scenes: see `Scenes`.
    """
    for scene, rows in trajectories.groupby("scene", sort=True):
        problems = read_problems(*scenes[scene])
        for coverage, part in rows.groupby("coverage", sort=True):
            yield problems[coverage], part.sort_values("rank")


def training_data(trajectories: pd.DataFrame, scenes: Scenes, policy: Policy) -> list[Trajectory]:
    """Return the trajectories' inputs as the policy will see them.

    Arguments are those of `labelled_problems`.
    """
    return [
        trajectory
        for problem, part in labelled_problems(trajectories, scenes)
        for trajectory in as_seen(problem, part.to_dict("records"), policy)
    ]


def as_seen(problem: Problem, rows: Iterable[Mapping], policy: Policy) -> Iterator[Trajectory]:
    """Yield trajectories of one problem with their inputs as the policy will see them.

    Args:
        problem: that was labelled.
        rows: picks and weight of each, see `fsel.training.ordering.ordered_item`.
        policy: that is trained.
    """
    prepared = policy.prepare(problem)
    for row in rows:
        picks = np.searchsorted(prepared.pool, np.array(row["picks"]))
        features, selectable = follow(Rollout(prepared), picks)
        yield Trajectory(features, selectable, picks, row["weight"])
