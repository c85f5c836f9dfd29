"""Trajectories of labelled problems, as a policy sees them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.columns import Columns, by_row
from fsel.core.problem import Problem
from fsel.selectors.policies import Policy
from fsel.selectors.rollout import Rollout, follow
from fsel.training.imitation import Trajectory
from fsel.training.problems import read_problems

Scenes = Mapping[str, Sequence[str | Path]]
"""Scene -> the arguments of `read_problems`."""


def labelled_problems(
    trajectories: Columns, scenes: Scenes
) -> Iterator[tuple[Problem, list[dict[str, Any]]]]:
    """Yield the problem of every scene and coverage level, and its rows of the table, best first.

    Args:
        trajectories: what `fsel.stages.order` wrote.
        scenes: see `Scenes`.
    """
    rows = sorted(by_row(trajectories), key=itemgetter("scene", "coverage", "rank"))
    for scene, own in groupby(rows, itemgetter("scene")):
        problems = read_problems(*scenes[scene])
        for coverage, part in groupby(own, itemgetter("coverage")):
            yield problems[coverage], list(part)


def training_data(trajectories: Columns, scenes: Scenes, policy: Policy) -> list[Trajectory]:
    """Return the trajectories' inputs as the policy will see them.

    Arguments are those of `labelled_problems`.
    """
    return [
        trajectory
        for problem, rows in labelled_problems(trajectories, scenes)
        for trajectory in as_seen(problem, rows, policy)
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
