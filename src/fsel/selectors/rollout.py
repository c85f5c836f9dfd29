"""Rollouts: the inputs that a scorer is shown along a sequence of picks, for training."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.features.columns import FOLLOWING, FOLLOWING_INPUTS, INPUTS, TARGET_GAIN_INPUT
from fsel.selectors import reference_loop
from fsel.selectors.greedy import Prepared, loop
from fsel.selectors.policies import KNOWN, ScoringMethod
from fsel.selectors.scorer import Linear

Score = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(t, n, 19) inputs and (t, n) selectable rows of all steps so far, (t - 1,) picks -> (n,) scores
for the last step."""


class Rollout:
    """The inputs of a selection problem while rows are picked.

    Attributes:
        prepared: see `fsel.selectors.policies.Policy.prepare`.
        picked: rows so far, in order.
        selectable: (n,) bool, False once a row is picked.
    """

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        self.picked: list[int] = []
        self.selectable = np.ones(len(prepared.pool), dtype=bool)
        self._raw, self._memory = loop().begin(prepared.rows)

    def inputs(self) -> np.ndarray:
        """Return (n, 19) float32 inputs at the present step: those that follow the selection are
        standardised over the rows that are left, and zero before the first pick, but for the target
        gain."""
        following = np.empty((len(self.selectable), FOLLOWING))
        loop().standardise_rows(self._raw, self.selectable, following)
        values = self.prepared.static.astype(np.float32)
        values[:, FOLLOWING_INPUTS] += following
        return values

    def add(self, row: int) -> None:
        """Pick a row."""
        self.selectable[row] = False
        self.picked.append(row)
        loop().update(row, self.selectable, self.prepared.rows, self._memory, self._raw)


def follow(rollout: Rollout, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K, n, 19) float32 inputs and (K, n) bool selectable rows before each of K given picks."""
    features = np.empty((len(rows), len(rollout.selectable), INPUTS), dtype=np.float32)
    selectable = np.empty(features.shape[:2], dtype=bool)
    for step, row in enumerate(rows):
        features[step], selectable[step] = rollout.inputs(), rollout.selectable
        rollout.add(int(row))
    return features, selectable


def pick(rollout: Rollout, score: Score, k: int) -> np.ndarray:
    """(k,) int64 rows, the best-scored one that is left at each step; ties go to the lowest."""
    features = np.empty((k, len(rollout.selectable), INPUTS), dtype=np.float32)
    selectable = np.empty(features.shape[:2], dtype=bool)
    for step in range(k):
        features[step], selectable[step] = rollout.inputs(), rollout.selectable
        past = np.array(rollout.picked, dtype=np.int64)
        scores = score(features[: step + 1], selectable[: step + 1], past)
        rollout.add(int(np.argmax(np.where(rollout.selectable, scores, -np.inf))))
    return np.array(rollout.picked, dtype=np.int64)


class RejectionScores(NamedTuple):
    """Scores of a pool, (n,) ascending frames, at the last pick of a linear rule: the sum of what
    each frame shows of the views (target gain) and how far it lies apart from the earlier picks."""

    pool: np.ndarray
    views: np.ndarray
    apart: np.ndarray


def explain_rejections(
    method: Method, problem: Problem, picks: np.ndarray
) -> RejectionScores | None:
    """Score every frame that may be picked, before the last of (k,) picks is; None for a method
    that is no linear rule."""
    if not isinstance(method, ScoringMethod) or not isinstance(method.scorer, Linear):
        return None
    prepared = KNOWN[method.name].prepare(problem)
    small = len(picks) * len(prepared.pool) <= reference_loop.LARGEST
    walk = (reference_loop.Walk if small else Rollout)(prepared)
    for row in np.searchsorted(prepared.pool, picks[:-1]):
        walk.add(int(row))
    parts = walk.inputs() * method.scorer.vector
    views = parts[:, TARGET_GAIN_INPUT]
    return RejectionScores(prepared.pool, views, parts.sum(axis=1) - views)
