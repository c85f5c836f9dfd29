"""Every candidate: the full sequence, without selection (paper, `tab:time_quality`)."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the start of the whole sequence; of more frames than it has, of all candidates."""
    frames = problem.sequence
    return (frames if k <= len(frames) else problem.candidates)[:k]


METHOD = Method("all", "All frames", "candidates", nested=True, select=select)
