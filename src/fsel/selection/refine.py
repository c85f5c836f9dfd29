"""Limits of the swaps that make picks better, and their result; see `fsel.selection.swaps`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from fsel.core.wording import check_type
from fsel.selection.patience import Trial

SETTINGS: dict[str, dict[str, Any]] = {
    "splats": {},
    "gaussians": {"steps": 150, "gaussians": 2000, "background": "mean"},
    "radiance_field": {"sides": (24, 48), "steps": (80, 80), "rays": 512},
}
"""Reconstructors that may score swaps, and their settings at 64 pixels: a second a subset."""


@dataclass(frozen=True)
class Swapped:
    """Picks after some swaps.

    Attributes:
        picks: (K,) int64, the best so far; a frame that was swapped in has the place in pick order
            of the one that left.
        gain: mean PSNR of the targets over what the picks at the start give, dB; an estimate.
        tried: subsets reconstructed, the start included.
        reconstructor: by which the gain is scored.
        fresh: where nobody says what will be rendered, what `splats` and `gaussians` say of the
            swapped picks on frames that scored no swap; None before, or where no swap was better.
        kept: whether that confirms them; else `picks` are those of the start again.
    """

    picks: np.ndarray
    gain: float
    tried: int
    reconstructor: str = "splats"
    fresh: Trial | None = None
    kept: bool = True


@dataclass(frozen=True)
class Refine:
    """A limit of the time that swaps take.

    Attributes:
        seconds: from the end of the first reconstruction on, which may have to be compiled.
        progress: is given the best so far and the seconds gone, after every subset; False ends
            the swaps.
        reconstructor: by which swaps are scored, a key of `SETTINGS`: picks that it prefers need
            not be better for another. None: `gaussians` where nobody says what will be rendered,
            see docs/results/refine.md; else `splats`.
    """

    seconds: float
    progress: Callable[[Swapped, float], bool] = lambda best, gone: True
    reconstructor: str | None = None

    def __post_init__(self) -> None:
        check_type("refine", self.seconds, Real, "seconds")
        if not self.seconds > 0:
            raise ValueError(f"refine is {self.seconds} s; allowed: more than 0")
        if self.reconstructor is not None and self.reconstructor not in SETTINGS:
            raise ValueError(
                f"the reconstructor of refine is {self.reconstructor!r}; allowed: "
                f"{', '.join(SETTINGS)}"
            )
