"""Contract of metrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the workflow is read without it
    import numpy as np


@dataclass(frozen=True)
class Metric:
    """A metric of images.

    Attributes:
        name: key in the registry, in the config and in every table's file.
        label: how printed tables head its column.
        higher_is_better: its direction.
        score: (rendered (T, h, w, 3) float32 in [0, 1], truth (T, h, w, 3) uint8, masks (T, h, w)
            bool or None) -> (T,) float64, of the part inside the mask. Settings are keywords.
        unit: of its values; empty where they have none.
        digits: decimals that tables print.
        check: refuses settings that `score` could not work with; None where there are none.
    """

    name: str
    label: str
    higher_is_better: bool
    score: Callable[..., np.ndarray]
    unit: str = ""
    digits: int = 3
    check: Callable[..., None] | None = None

    def printed(self, value: float) -> str:
        """Return a value with its decimals."""
        return f"{value:.{self.digits}f}"
