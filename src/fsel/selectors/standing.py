"""Standing of the rows that a linear rule left out: their scores at its last pick, in two parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.features.columns import TARGET_GAIN_INPUT
from fsel.selectors import plain
from fsel.selectors.policies import KNOWN, Learned
from fsel.selectors.rollout import Rollout
from fsel.selectors.scorer import Linear


@dataclass(frozen=True)
class Standing:
    """Scores of a pool at the last pick, which are sums of two parts.

    Attributes:
        pool: (n,) int64 frames, ascending.
        views: (n,) what a frame shows of the views beyond the earlier picks: the target gain.
        apart: (n,) how far it lies from the earlier picks: all other inputs of the rule.
    """

    pool: np.ndarray
    views: np.ndarray
    apart: np.ndarray


def standing(method: Method, problem: Problem, picks: np.ndarray) -> Standing | None:
    """Scores of every frame that may be picked, before the last of some picks is.

    Args:
        method: that picked.
        problem: what it was given.
        picks: (k,) frames of the pool, in pick order.

    Returns:
        None for a method that is no linear rule: a network's score has no such parts.
    """
    if not isinstance(method, Learned) or not isinstance(method.scorer, Linear):
        return None
    prepared = KNOWN[method.name].prepare(problem)
    small = len(picks) * len(prepared.pool) <= plain.LARGEST
    walk = (plain.Walk if small else Rollout)(prepared)
    for row in np.searchsorted(prepared.pool, picks[:-1]):
        walk.add(int(row))
    parts = walk.inputs() * method.scorer.vector
    views = parts[:, TARGET_GAIN_INPUT]
    return Standing(prepared.pool, views, parts.sum(axis=1) - views)
