"""Rollouts: the inputs that a scorer is shown along a sequence of picks.

Training follows a label's picks, and a scorer of any kind its own, through the same inputs.
`fsel.selectors.greedy` is the fast form for the scorers that select.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.features.columns import FOLLOWING, FOLLOWING_INPUTS, INPUTS
from fsel.selectors.greedy import Prepared, loop

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
        """(n, 19) float32 inputs at the present step.

        Those that follow the selection are standardised over the rows that are left, and zero
        before the first pick (paper, section 3.2), but for the target gain. It keeps its unit, the
        closest frame of all views: as views are served it fades beside the others, and the policy
        turns from the targets to diversity.
        """
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
