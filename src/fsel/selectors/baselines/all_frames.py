"""Every observed frame: the full sequence, without selection."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the start of the whole sequence; of more frames than it has, of those observed."""
    frames = problem.sequence
    return (frames if k <= len(frames) else problem.observed)[:k]


METHOD = Method("all", "All frames", "observed", nested=True, select=select)
