"""Fitting the policy to reconstruction itself: an evolution strategy over a few scorer weights.

The paper's scorer only imitates; its future work asks for policies that optimise subsets directly.
Here the sixty-four-unit network carries, exactly, a linear score of its inputs beside whatever it
has learned, and CMA-ES (Hansen, arXiv 1604.00772) moves that linear part to raise the quality of
real reconstructions at every budget.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cma
import numpy as np
import pandas as pd

from fsel.selector.scorer import INPUTS, WIDTH

Objective = Callable[[Sequence[np.ndarray], int], np.ndarray]


def linear_weights(coefficients: np.ndarray) -> dict[str, np.ndarray]:
    """The scorer's weights whose output is exactly `coefficients @ x`.

    GELU(z) - GELU(-z) = z, so a pair of hidden units passes a value through unchanged. Layer one
    holds such a pair for each input, layer two one pair for the sum.

    Args:
        coefficients: (19,) one weight an input.
    """
    if 2 * INPUTS > WIDTH or coefficients.shape != (INPUTS,):
        raise ValueError(f"expected ({INPUTS},) coefficients, got {coefficients.shape}")
    first = np.zeros((WIDTH, INPUTS), np.float32)
    first[np.arange(INPUTS), np.arange(INPUTS)] = 1
    first[INPUTS + np.arange(INPUTS), np.arange(INPUTS)] = -1
    second = np.zeros((WIDTH, WIDTH), np.float32)
    second[0, :INPUTS] = second[1, INPUTS : 2 * INPUTS] = coefficients
    second[0, INPUTS : 2 * INPUTS] = second[1, :INPUTS] = -coefficients
    third = np.zeros((1, WIDTH), np.float32)
    third[0, :2] = (1, -1)
    return {
        "layer1.weight": first,
        "layer1.bias": np.zeros(WIDTH, np.float32),
        "layer2.weight": second,
        "layer2.bias": np.zeros(WIDTH, np.float32),
        "layer3.weight": third,
        "layer3.bias": np.zeros(1, np.float32),
    }


@dataclass(frozen=True)
class RefineSettings:
    """CMA-ES: generations, policies a generation, first step size, problems a generation."""

    generations: int = 8
    population: int = 8
    step: float = 0.1
    batch: int = 8


def refine(
    objective: Objective,
    start: np.ndarray,
    free: np.ndarray,
    settings: RefineSettings,
    seed: int,
) -> tuple[np.ndarray, pd.DataFrame]:
    """Maximise an objective over linear score coefficients.

    Picks do not change when all coefficients are scaled together, so that one which is surely
    not zero had better be held.

    Args:
        objective: (list of (19,) coefficient vectors, generation) -> (policies,) values to raise;
            all policies of a generation must be measured on the same problems.
        start: (19,) coefficients to begin with.
        free: (19,) bool, False for coefficients that stay as they are.
        settings: see `RefineSettings`.
        seed: of the strategy's sampling.

    Returns:
        The final distribution mean (19,), which averages the noise of single generations out,
        and a log: generation, best, mean, step.
    """
    strategy = cma.CMAEvolutionStrategy(
        start[free],
        settings.step,
        {"seed": seed + 1, "popsize": settings.population, "verbose": -9, "verb_log": 0},
    )
    log = []
    for generation in range(settings.generations):
        asked = strategy.ask()
        values = objective([_spread(x, start, free) for x in asked], generation)
        strategy.tell(asked, (-values).tolist())
        log.append(
            {
                "generation": generation,
                "best": values.max(),
                "mean": values.mean(),
                "step": strategy.sigma,
            }
        )
    return _spread(strategy.mean, start, free), pd.DataFrame(log)


def _spread(values: np.ndarray, start: np.ndarray, free: np.ndarray) -> np.ndarray:
    full = start.copy()
    full[free] = values
    return full
