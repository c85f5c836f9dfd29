"""Inputs of a scorer when some features are withheld, or others take their place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsel.experiments.paper.ablation.extras import Extra, Relations
from fsel.features.columns import NAMES
from fsel.selectors.greedy import Prepared, standardise
from fsel.selectors.rollout import Rollout


class PartialRollout(Rollout):
    """A `Rollout` on some features only.

    Args:
        prepared: see `fsel.selectors.policies.Policy.prepare`.
        scene: relations of the same pool; read by `added` alone.
        shown: features whose inputs are not held at zero.
        added: three further features, or None.
    """

    def __init__(
        self, prepared: Prepared, scene: Relations, shown: Sequence[str], added: Extra | None
    ) -> None:
        super().__init__(prepared)
        self._scene, self._added = scene, added
        self._shown = np.isin(NAMES, list(shown)).astype(np.float32)

    def inputs(self) -> np.ndarray:
        """(n, 19) float32 inputs at the present step."""
        values = super().inputs()
        values *= self._shown
        if self._added is not None:
            raw = self._added.raw(self._scene, self.picked)
            values[:, self._added.inputs] = self._added.scale(raw, self.selectable)
        return values


def view_inputs(scene: Relations) -> np.ndarray:
    """(n, O, 3) float32 distance, angle and likeness to each proxy, z-scores over all pairs."""
    values = np.stack([scene.distance, scene.angle, scene.likeness], axis=-1)
    return standardise(values.reshape(-1, 3)).reshape(values.shape).astype(np.float32)
