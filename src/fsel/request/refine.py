"""Limits of the swaps that make picks better, and their result; see `fsel.request.swaps`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Swapped:
    """Picks after some swaps.

    Attributes:
        picks: (K,) int64, the best so far; a frame that was swapped in has the place in pick order
            of the one that left.
        gain: mean PSNR of the targets over what the picks at the start give, dB; an estimate.
        tried: subsets reconstructed, the start included.
    """

    picks: np.ndarray
    gain: float
    tried: int


@dataclass(frozen=True)
class Refine:
    """A limit of the time that swaps take.

    Attributes:
        seconds: from the first reconstruction on.
        progress: is given the best so far and the seconds gone, after every subset; False ends
            the swaps.
    """

    seconds: float
    progress: Callable[[Swapped, float], bool] = lambda best, gone: True

    def __post_init__(self) -> None:
        if not self.seconds > 0:
            raise ValueError(f"refine is {self.seconds} s; allowed: more than 0")
