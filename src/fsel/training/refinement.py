"""Fitting a linear policy to reconstruction itself: CMA-ES (Hansen, arXiv 1604.00772) moves its
coefficients to raise the quality of real reconstructions at every budget."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cma
import numpy as np

from fsel.core.files import by_column

Coefficients = Mapping[str, float]
Objective = Callable[[Sequence[Coefficients], int], np.ndarray]


@dataclass(frozen=True)
class RefineSettings:
    """CMA-ES: generations, policies a generation, first step size, problems a generation."""

    generations: int = 8
    population: int = 8
    step: float = 0.1
    batch: int = 8


def refine(
    objective: Objective,
    start: Coefficients,
    free: Sequence[str],
    settings: RefineSettings,
    seed: int,
) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """Maximise an objective over the coefficients of a linear rule.

    Args:
        objective: (coefficients of some policies, generation) -> (policies,) values to raise, of a
            generation all measured on the same problems.
        start: name of an input -> coefficient to begin with.
        free: those that may move. Picks stay where all are scaled alike: hold one that is not zero.

    Returns:
        The final distribution's mean, and a log: generation, best, mean, step.
    """

    def policy(values: np.ndarray) -> dict[str, float]:
        return {**start, **dict(zip(free, values.tolist(), strict=True))}

    strategy = cma.CMAEvolutionStrategy(
        [start[name] for name in free],
        settings.step,
        {"seed": seed + 1, "popsize": settings.population, "verbose": -9, "verb_log": 0},
    )
    log = []
    for generation in range(settings.generations):
        sampled = strategy.ask()
        values = objective([policy(x) for x in sampled], generation)
        strategy.tell(sampled, (-values).tolist())
        reached = {"best": values.max(), "mean": values.mean(), "step": strategy.sigma}
        log.append({"generation": generation} | reached)
    return policy(strategy.mean), by_column(log)
