"""The sharpest frame of each stretch of the capture: what frame-extraction tools do."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Cut the pool in capture order into k windows as equal as can be; ties go to the lowest."""
    pool = problem.observed
    windows = np.array_split(pool, k)
    return np.array([window[np.argmax(problem.sharpness[window])] for window in windows])


METHOD = Method(
    "sharpest", "Sharpest per window", "observed", nested=False, select=select, reads=("sharpness",)
)
