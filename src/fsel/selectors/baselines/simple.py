"""Random, uniform, sharpest and all frames: what needs neither poses nor points."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly


def random(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the first k of a random order of the pool, so that budgets nest."""
    return rng.permutation(problem.observed)[:k]


def uniform(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick rows round(linspace(0, n - 1, k)) of the pool, in capture order."""
    pool = problem.observed
    return pool[evenly(len(pool), k)]


def sharpest(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the sharpest of each of k windows of the pool in capture order, as equal as can be, as
    frame-extraction tools do; ties go to the lowest."""
    pool = problem.observed
    windows = np.array_split(pool, k)
    return np.array([window[np.argmax(problem.sharpness[window])] for window in windows])


def every(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the start of the whole sequence, without selection (paper, `tab:time_quality`); of
    more frames than it has, of all candidates."""
    frames = problem.sequence
    return (frames if k <= len(frames) else problem.candidates)[:k]


RANDOM = Method("random", "Random", "observed", nested=True, seeds=3, select=random)
UNIFORM = Method("uniform", "Uniform", "observed", nested=False, select=uniform)
SHARPEST = Method(
    *("sharpest", "Sharpest per window", "observed"),
    nested=False,
    select=sharpest,
    reads=("sharpness",),
)
ALL = Method("all", "All frames", "candidates", nested=True, select=every)
