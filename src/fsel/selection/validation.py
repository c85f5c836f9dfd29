"""How long selections are tried on a capture, and what was found; see `fsel.selection.halving`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import NamedTuple

import numpy as np

from fsel.core.wording import check_type

DEFAULT, KNOWN = 10.0, 60.0  # seconds, the latter of no more picks than targets
CEILING = 6.0  # times the patience after which planned reconstructions are left out
LEAST_TARGETS = 3  # of which there are images
LEAST_GAIN = 0.2  # dB that each reconstructor alone puts a selection ahead by, where both score


@dataclass(frozen=True)
class CandidateScore:
    """A selection that was tried.

    Attributes:
        name: what made it.
        frames: (K,) int64, ascending.
        gain: mean PSNR over that of the first selection, dB, by those of `splats` and `gaussians`
            that were fitted; NaN where too few frames are left to score on.
        least: the lesser of the two gains.
        ssim: the same of SSIM.
        error: standard error of the gain, dB; infinite where `gaussians` were not fitted.
        validation: how many frames both were scored on, which neither holds.
        fits: reconstructions of it.
    """

    name: str
    frames: np.ndarray
    gain: float
    least: float
    ssim: float
    error: float
    validation: int
    fits: int


@dataclass(frozen=True)
class ValidationResult:
    """Outcome of trying selections.

    Attributes:
        trials: first uniform sampling, or what the rule picks for stated targets.
        kept: name of the selection that was kept.
        fits: reconstructions, all together.
        cut: whether planned reconstructions were left out: interrupted, or at the time's ceiling.
        on_targets: whether the images of the targets were looked at.
        seconds: that were planned for.
    """

    trials: tuple[CandidateScore, ...]
    kept: str
    fits: int
    cut: bool
    on_targets: bool = False
    seconds: float = DEFAULT

    @property
    def frames(self) -> np.ndarray:
        """(K,) int64 of the selection that was kept, ascending."""
        return next(trial.frames for trial in self.trials if trial.name == self.kept)

    @property
    def validation(self) -> int:
        """The most frames that one selection was scored on."""
        return max(trial.validation for trial in self.trials)

    @property
    def rule(self) -> AcceptanceRule:
        """Conditions on which the first selection would have been replaced."""
        return STATED if self.on_targets else WHOLE


@dataclass(frozen=True)
class TimeBudget:
    """Time limit for validating selections on the capture.

    Attributes:
        seconds: as many reconstructions are planned as a slow processor makes in that time, so
            that a faster one ends sooner with the same picks; 0 validates nothing.
        progress: called with the fits made, those planned and the seconds; False ends it.
        ceiling: times the seconds, counted once all is read and compiled, after which
            reconstructions that are not made are left out.
    """

    seconds: float = DEFAULT
    progress: Callable[[int, int, float], bool] = lambda made, planned, gone: True
    ceiling: float = CEILING

    def __post_init__(self) -> None:
        check_type("patience", self.seconds, Real, "seconds")
        if not self.seconds >= 0:
            raise ValueError(f"patience is {self.seconds} s; allowed: 0 or more")


class AcceptanceRule(NamedTuple):
    """Conditions on which another selection is kept in place of the first one.

    Attributes:
        margin: dB that it is to be ahead by.
        validation: frames at least that neither holds.
        sure: whether `splats` must agree, SSIM not be less, and the lead be beyond chance, since
            the frames that are scored stand for others; else `gaussians` alone score.
    """

    margin: float
    validation: int
    sure: bool

    def agreed(self, trial: CandidateScore) -> bool:
        """Return whether each reconstructor puts a selection ahead, and not behind in SSIM."""
        return not self.sure or (trial.least > LEAST_GAIN and trial.ssim >= 0)


WHOLE = AcceptanceRule(0.5, 8, True)
STATED = AcceptanceRule(0.2, LEAST_TARGETS, False)
