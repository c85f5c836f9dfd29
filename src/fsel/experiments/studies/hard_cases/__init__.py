"""Hard cases: small inputs on which careless arithmetic fails, and what their exact answers are.

The tests and `results/tables/stability.csv` run `fsel.experiments.studies.stability.CASES`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsel.core.capture import Capture
from fsel.evaluation.evaluator import evaluators


@dataclass(frozen=True)
class CaseOutcome:
    """What a case showed, in words; its largest deviation from the float64 or exact answer; what is
    allowed; and the PSNR in dB that the case costs, NaN where there is nothing to compare with."""

    observed: str
    error: float
    allowed: float
    lost: float = np.nan

    @property
    def holds(self) -> bool:
        """Say whether the answer is right to rounding; never for an error that is NaN."""
        return self.error <= self.allowed


@dataclass(frozen=True)
class Case:
    """A hard case: its name, what must hold beside finite numbers and no warning, and what runs
    it."""

    name: str
    expected: str
    run: Callable[[], CaseOutcome]


def observe(case: Case) -> CaseOutcome:
    """Run a case; what it raises is its finding, with an infinite error: every warning, overflow,
    division by zero and invalid operation, but no underflow."""
    try:
        with warnings.catch_warnings(), np.errstate(divide="raise", over="raise", invalid="raise"):
            warnings.simplefilter("error")
            return case.run()
    except (ArithmeticError, RuntimeError, ValueError, Warning) as fault:
        return CaseOutcome(f"{type(fault).__name__}: {fault}", np.inf, 0.0)


def finite(*arrays: np.ndarray) -> None:
    """Raise FloatingPointError for a NaN or an infinity, which compiled code makes silently."""
    for array in arrays:
        bad = np.size(array) - int(np.isfinite(array).sum())
        if bad:
            raise FloatingPointError(f"{bad} of {np.size(array)} numbers are not finite")


def quality(capture: Capture, frames: np.ndarray, targets: np.ndarray) -> float:
    """Return the PSNR in dB on targets, by `splats`; every metric must be finite."""
    whole = {"name": "splats", "long_side": max(capture.size), "settings": {}}
    scores = evaluators(whole)(capture, targets)(frames)
    finite(scores)
    return float(scores[0])
