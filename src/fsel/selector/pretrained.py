"""The scorer that comes with the package."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import numpy as np

from fsel.problem import Problem
from fsel.selector import greedy, plain
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Scorer

POLICY = POLICIES["fsel"]
WEIGHTS = "fsel.safetensors"
FOLDER = Path(__file__).parent / "weights"


@cache
def scorer() -> Scorer:
    """The shipped weights with their provenance; `make weights` remakes them."""
    return Scorer.load(FOLDER / WEIGHTS)


def digest(folder: Path = FOLDER) -> str:
    """SHA-256 of the weights file, hexadecimal."""
    return hashlib.sha256((folder / WEIGHTS).read_bytes()).hexdigest()


def ranked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick k of all frames that may be used, with the shipped scorer.

    Args:
        problem: the selection problem.
        k: at most the size of the pool.

    Returns:
        (k,) int64 frames in pick order, and (k,) float64 their scores when picked.
    """
    prepared = POLICY.prepare(problem)
    small = len(prepared.pool) <= plain.LARGEST_POOL
    pick = plain.greedy if small else greedy.greedy
    rows, scores = pick(prepared, scorer().weights, k)
    return prepared.pool[rows], scores
