"""Trajectories of labelled problems, as a policy sees them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.problem import Problem
from fsel.selector.policies import Policy
from fsel.selector.rollout import Rollout, follow
from fsel.training.imitation import Trajectory
from fsel.training.problems import read_problems

Scenes = Mapping[str, Sequence[str | Path]]
"""Scene -> the arguments of `read_problems`."""


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
