"""Labelled problems and their trajectories, read from what the workflow wrote."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.selector.policies import Policy
from fsel.selector.rollout import Rollout, follow
from fsel.training.imitation import Trajectory
from fsel.utils.files import read_table

Scenes = Mapping[str, tuple[str | Path, str | Path]]
"""Scene -> folder of its canonical capture, and path of the splits of all its coverage levels."""


def labelled_problems(
    trajectories: pd.DataFrame, scenes: Scenes
) -> Iterator[tuple[Problem, pd.DataFrame]]:
    """The problem of every scene and coverage level, and its rows of the table, best first.

    The files of a scene are read once for all of its levels.

    Args:
        trajectories: what `fsel.stages.order` wrote.
        scenes: see `Scenes`.
    """
    for scene, rows in trajectories.groupby("scene", sort=True):
        folder, splits = scenes[scene]
        capture, table = Capture.load(folder), read_table(splits)
        described = read_table(Path(folder) / "descriptors.parquet")
        for coverage, part in rows.groupby("coverage", sort=True):
            split = Split.from_table(table[table["coverage"] == coverage])
            yield Problem.of(capture, split, described), part.sort_values("rank")


def training_data(trajectories: pd.DataFrame, scenes: Scenes, policy: Policy) -> list[Trajectory]:
    """The trajectories' inputs as the policy will see them; arguments as `labelled_problems`."""
    return [
        trajectory
        for problem, part in labelled_problems(trajectories, scenes)
        for trajectory in as_seen(problem, part.to_dict("records"), policy)
    ]


def as_seen(problem: Problem, rows: Iterable[Mapping], policy: Policy) -> Iterator[Trajectory]:
    """Trajectories of one problem with their inputs as the policy will see them.

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
