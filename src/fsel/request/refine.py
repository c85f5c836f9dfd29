"""For how long picks are made better by swaps, and what comes of it; see `fsel.request.swaps`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

JUDGES: dict[str, dict[str, int]] = {
    "splats": {},
    "gaussians": {"steps": 150, "gaussians": 2000},
    "radiance_field": {},
}
"""Reconstructors that may judge swaps, and their settings at 64 pixels."""


@dataclass(frozen=True)
class Swapped:
    """Picks after some swaps.

    Attributes:
        picks: (K,) int64, the best so far; a frame that was swapped in has the place in pick order
            of the one that left.
        gain: mean PSNR of the targets over what the picks at the start give, dB; an estimate.
        tried: subsets reconstructed, the start included.
        reconstructor: that judged.
    """

    picks: np.ndarray
    gain: float
    tried: int
    reconstructor: str = "splats"


@dataclass(frozen=True)
class Refine:
    """How long swaps may go on.

    Attributes:
        seconds: from the first reconstruction on.
        told: is given the best so far and the seconds gone, after every subset; False ends the
            swaps.
        reconstructor: that judges, a key of `JUDGES`: picks that it prefers need not be better for
            another.
    """

    seconds: float
    told: Callable[[Swapped, float], bool] = lambda best, gone: True
    reconstructor: str = "splats"

    def __post_init__(self) -> None:
        if not self.seconds > 0:
            raise ValueError(f"refine is {self.seconds} s; allowed: more than 0")
        if self.reconstructor not in JUDGES:
            raise ValueError(
                f"refine is judged by {self.reconstructor!r}; allowed: {', '.join(JUDGES)}"
            )
