"""What a scorer is shown along a sequence of picks, for any choice of features.

Training follows a label's picks and selection its own, through the same inputs. The deployed
scorer's selection (`fsel.selector.greedy`) is the fast form for the full features.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fsel.experiments.ablation.extras import Extra, Relations
from fsel.features.static import FEATURES
from fsel.selector.greedy import DYNAMIC, Prepared, State, standardise
from fsel.selector.scorer import INPUTS

Score = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(t, n, 19) inputs and (t, n) selectable rows of all steps so far, (t - 1,) picks -> (n,) scores
for the last step."""


class Walk:
    """The inputs of a selection problem while frames are picked.

    Args:
        prepared: see `fsel.selector.greedy.prepare`.
        scene: relations of the same pool; read by `added` alone.
        shown: features whose inputs are not held at zero.
        added: three further features, or None.
    """

    def __init__(
        self, prepared: Prepared, scene: Relations, shown: Sequence[str], added: Extra | None
    ) -> None:
        self.state = State(prepared)
        self.picked: list[int] = []
        self._static = prepared.static.astype(np.float32)
        self._scene, self._added = scene, added
        self._shown = np.isin([*FEATURES, ""], list(shown)).astype(np.float32)

    @property
    def selectable(self) -> np.ndarray:
        """(n,) bool, False once a row is picked."""
        return self.state.selectable

    def inputs(self) -> np.ndarray:
        """(n, 19) float32 inputs at the present step."""
        values = self._static.copy()
        values[:, DYNAMIC] += self.state.inputs()
        values *= self._shown
        if self._added is not None:
            raw = self._added.raw(self._scene, self.picked)
            values[:, self._added.inputs] = self._added.scale(raw, self.selectable)
        return values

    def add(self, row: int) -> None:
        """Pick a row."""
        self.state.add(row)
        self.picked.append(row)


def follow(walk: Walk, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K, n, 19) float32 inputs and (K, n) bool selectable rows before each of K given picks."""
    features = np.empty((len(rows), len(walk.selectable), INPUTS), dtype=np.float32)
    selectable = np.empty(features.shape[:2], dtype=bool)
    for step, row in enumerate(rows):
        features[step], selectable[step] = walk.inputs(), walk.selectable
        walk.add(int(row))
    return features, selectable


def pick(walk: Walk, score: Score, k: int) -> np.ndarray:
    """(k,) int64 rows, the best-scored one that is left at each step; ties go to the lowest."""
    features = np.empty((k, len(walk.selectable), INPUTS), dtype=np.float32)
    selectable = np.empty(features.shape[:2], dtype=bool)
    for step in range(k):
        features[step], selectable[step] = walk.inputs(), walk.selectable
        past = np.array(walk.picked, dtype=np.int64)
        scores = score(features[: step + 1], selectable[: step + 1], past)
        walk.add(int(np.argmax(np.where(walk.selectable, scores, -np.inf))))
    return np.array(walk.picked, dtype=np.int64)


def view_inputs(scene: Relations) -> np.ndarray:
    """(n, O, 3) float32 distance, angle and likeness to each proxy, z-scores over all pairs."""
    values = np.stack([scene.distance, scene.angle, scene.likeness], axis=-1)
    return standardise(values.reshape(-1, 3)).reshape(values.shape).astype(np.float32)
