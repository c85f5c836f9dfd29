"""Steps of one trajectory, which every scorer reads."""

from __future__ import annotations

from dataclasses import dataclass

import torch


@dataclass(frozen=True)
class Steps:
    """K steps over a pool of n frames, in capture order.

    A scorer maps it to (K, n) scores. Those of step t may depend on the picks of the steps before
    t, never on its own or a later one.

    Attributes:
        features: (K, n, 19) float32 standardised inputs.
        selectable: (K, n) bool, False once a row is picked; no scorer need mask its own scores.
        picks: (K,) int64 row picked at each step.
        views: (n, O, 3) float32 standardised distance, angle and likeness to each proxy.
    """

    features: torch.Tensor
    selectable: torch.Tensor
    picks: torch.Tensor
    views: torch.Tensor

    def before(self, values: torch.Tensor) -> torch.Tensor:
        """(K, ...) what was picked one step before: zero at the first, then `values` of the picks.

        Args:
            values: (K, n, ...) of every row at every step.
        """
        taken = values[torch.arange(len(self.picks)), self.picks]
        return torch.cat([torch.zeros_like(taken[:1]), taken[:-1]])
