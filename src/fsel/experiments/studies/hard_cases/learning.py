"""Searches and training on labels that are constant, or extreme."""

from __future__ import annotations

import numpy as np

from fsel.experiments.studies.hard_cases import worlds
from fsel.experiments.studies.hard_cases.case import Case, Finding, finite
from fsel.features.columns import INPUTS
from fsel.training.ordering import order_subset, trajectory_weights
from fsel.training.search import (
    GeneticSettings,
    fitness,
    genetic_search,
    random_search,
    swap_search,
)

K = 6


def equal_fitness() -> Finding:
    """Retained subsets of one fitness weigh the same, whatever the fitness is."""
    error = 0.0
    for level in (0.0, 1.0, 1 / 3, 1e-300):
        weights = trajectory_weights(np.full(4, level))
        finite(weights)
        error = max(error, float(np.abs(weights - 1).max()))
    return Finding("all weights 1" if error == 0 else "weights differ", error, 0.0)


def one_fitter_subset() -> Finding:
    """Fitnesses apart by one unit in the last place are as good as equal; weights keep mean one."""
    weights = trajectory_weights(np.array([0.5, 0.5, 0.5, np.nextafter(0.5, 1)]))
    finite(weights)
    return Finding(f"weights {np.round(weights, 4).tolist()}", float(np.ptp(weights)), 1e-3)


def equal_metrics() -> Finding:
    """Searches that cannot tell subsets apart still return distinct ones of the right size."""
    problem, rng = worlds.world(), np.random.default_rng(0)
    pool, centers = problem.candidates, problem.capture.centers

    def flat(subset: np.ndarray) -> np.ndarray:
        return np.array([20.0, 0.5, 0.1])

    small = GeneticSettings(population=8, farthest=3, uniform=2, generations=3)
    results = [
        genetic_search(flat, pool, pool, centers, K, rng, small),
        random_search(flat, pool, K, 20, rng),
        swap_search(flat, pool, [pool[:K]], 20, rng),
    ]
    error, sizes = 0.0, []
    for result in results:
        finite(result.fitness)
        error = max(error, float(np.abs(result.fitness).max()))
        distinct = {tuple(np.unique(subset)) for subset in result.subsets}
        sizes.append(len(distinct))
        if len(distinct) < len(result.subsets) or any(len(s) < K for s in distinct):
            error = np.inf
    return Finding(f"fitness 0; {sizes} distinct subsets", error, 0.0)


def far_metric() -> Finding:
    """A PSNR of 1e12 among ordinary ones leaves fitness in 0..1, and right to rounding."""
    metrics = np.array([[20.0, 0.5, 0.1], [21.0, 0.6, 0.1], [1e12, 0.55, 0.1]])
    got = fitness(metrics)
    finite(got)
    exact = np.array([0.0, (1 / (1e12 - 20) + 1) / 3, (1 + 0.5) / 3])
    return Finding(f"fitness {np.round(got, 6).tolist()}", float(np.abs(got - exact).max()), 1e-12)


def equal_distances() -> Finding:
    """Frames in one place that serve all views alike are taken in their own order."""
    apart = np.zeros((K, K))
    orders = [order_subset(np.full((K, 3), value), apart) for value in (0.0, 1e-300, 1e12)]
    error = max(float(np.abs(order - np.arange(K)).max()) for order in orders)
    return Finding("lowest rows first" if error == 0 else str(orders), error, 0.0)


def loud_training() -> Finding:
    """Inputs that make logits of 10^4: float32 losses against float64 ones."""
    import torch  # only training needs it

    from fsel.training.imitation import Trajectory, train

    rng = np.random.default_rng(0)
    items = []
    for _ in range(3):
        features = rng.normal(scale=2e5, size=(K, 20, INPUTS)).astype(np.float32)
        picks = rng.permutation(20)[:K]
        selectable = np.ones((K, 20), bool)
        for step in range(K):
            selectable[step, picks[:step]] = False
        items.append(Trajectory(features, selectable, picks, 1.0))
    logs = []
    for dtype in (torch.float32, torch.float64):
        settings = {"seed": 0, "epochs": 2, "learning_rate": 1e-3, "dtype": dtype}
        weights, log = train(items, [], **settings)
        finite(*weights.values(), log["loss"])
        logs.append(log["loss"])
    error = float(np.abs(logs[0][0] / logs[1][0] - 1))
    return Finding(f"loss {logs[1][0]:.4g}, after two epochs {logs[1][-1]:.4g}", error, 1e-5)


CASES = (
    Case("equal fitness of all retained subsets", "equal weights", equal_fitness),
    Case("fitness apart by one last bit", "equal weights to rounding", one_fitter_subset),
    Case("equal metrics of all evaluated subsets", "fitness 0, searches end", equal_metrics),
    Case("a metric with one outlier of 1e12", "fitness by hand", far_metric),
    Case("equal distances of a subset to all views", "order of the frames", equal_distances),
    Case("logits of 1e4, training", "the float64 loss", loud_training),
)
