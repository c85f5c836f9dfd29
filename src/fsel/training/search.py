"""Subset searches scored by real reconstruction: the paper's, and a random one.

Both return every distinct subset that they evaluated, and are deterministic given the generator: a
search that was cut off resumes by replaying with an `evaluate` that remembers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from fsel.core.geometry import farthest_views
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.core.subsets import subset_key
from fsel.metrics import METRICS, Metrics

Evaluate = Callable[[np.ndarray], np.ndarray]
"""(K,) ascending frames -> (3,) PSNR, SSIM, perceptual distance."""


@dataclass(frozen=True)
class GeneticSettings:
    """The genetic search of the paper, Appendix A.2; defaults are the paper's."""

    population: int = 40
    farthest: int = 16
    uniform: int = 12
    generations: int = 15
    elites: int = 2
    tournament: int = 4
    crossover: float = 0.8
    mutation: float = 0.3


@dataclass(frozen=True)
class SearchResult:
    """Every distinct subset of a search, in the order of evaluation.

    Attributes:
        subsets: (n, K) int64, each row ascending.
        metrics: (n, 3) float64, PSNR, SSIM, perceptual distance.
        fitness: (n,) float64 in [0, 1], over all rows together (paper, section 3.4).
        generation: (n,) int64 that first met the subset.
    """

    subsets: np.ndarray
    metrics: np.ndarray
    fitness: np.ndarray
    generation: np.ndarray

    def best(self, count: int) -> np.ndarray:
        """Rows of the `count` fittest subsets, fittest first, earliest first among equals."""
        return np.argsort(-self.fitness, kind="stable")[:count]


def fitness(metrics: np.ndarray) -> np.ndarray:
    """Return (n,) means of (n, 3) min-max normalised PSNR, SSIM and negated perceptual distance
    (paper, section 3.4); a metric equal for all subsets counts as 0."""
    signed = metrics * np.array([1.0, 1.0, -1.0])
    low, span = signed.min(axis=0), np.ptp(signed, axis=0)
    return ((signed - low) / np.where(span > 0, span, 1.0)).mean(axis=1)


@dataclass
class _Archive:
    """Distinct subsets and their metrics; evaluates each only once."""

    evaluate: Evaluate
    rows: dict[tuple[int, ...], int] = field(default_factory=dict)
    metrics: list[np.ndarray] = field(default_factory=list)
    generation: list[int] = field(default_factory=list)

    def row(self, subset: np.ndarray, generation: int) -> int:
        key = subset_key(subset)
        if key not in self.rows:
            self.rows[key] = len(self.metrics)
            self.metrics.append(np.asarray(self.evaluate(np.array(key, dtype=np.int64)), float))
            self.generation.append(generation)
        return self.rows[key]

    def __len__(self) -> int:
        return len(self.metrics)

    def fitness(self) -> np.ndarray:
        return fitness(np.array(self.metrics))

    def result(self) -> SearchResult:
        return SearchResult(
            subsets=np.array(list(self.rows), dtype=np.int64),
            metrics=np.array(self.metrics),
            fitness=self.fitness(),
            generation=np.array(self.generation),
        )


def genetic_search(
    evaluate: Evaluate,
    pool: np.ndarray,
    region: np.ndarray,
    centers: np.ndarray,
    k: int,
    rng: np.random.Generator,
    settings: GeneticSettings | None = None,
) -> SearchResult:
    """Run the paper's search (section 3.4, Appendix A.2) for subsets of k of the (P,) `pool`, whose
    (R,) `region` is inside the target region; `centers` are (N, 3)."""
    settings = settings or GeneticSettings()
    _check_size(k, pool)
    archive = _Archive(evaluate)
    population = initial_population(pool, region, centers, k, rng, settings)
    rows = [archive.row(subset, 0) for subset in population]
    for generation in range(1, settings.generations + 1):
        score = archive.fitness()[rows]
        elites = np.argsort(-score, kind="stable")[: settings.elites]
        children = [
            offspring(population, score, pool, k, rng, settings)
            for _ in range(settings.population - settings.elites)
        ]
        population = [population[i] for i in elites] + children
        rows = [archive.row(subset, generation) for subset in population]
    return archive.result()


def initial_population(
    pool: np.ndarray,
    region: np.ndarray,
    centers: np.ndarray,
    k: int,
    rng: np.random.Generator,
    settings: GeneticSettings,
) -> list[np.ndarray]:
    """Return farthest-view, uniformly spaced and random subsets of the region (Appendix A.2),
    completed by random frames of the pool."""
    region = region if len(region) else pool
    anchors = rng.permutation(np.resize(region, max(len(region), settings.farthest)))
    subsets = [farthest_views(region, centers, k, int(a)) for a in anchors[: settings.farthest]]
    for phase in (np.arange(settings.uniform) + 0.5) / settings.uniform:
        step = len(region) / k
        subsets.append(region[np.unique(((np.arange(k) + phase) * step).astype(int))])
    for _ in range(settings.population - settings.farthest - settings.uniform):
        subsets.append(rng.permutation(region)[:k])
    return [_filled(subset, pool, k, rng) for subset in subsets]


def fittest_so_far(fitness: np.ndarray) -> np.ndarray:
    """Return (n,) int64, which of (n,) subsets is the fittest until each evaluation, the first of
    equals."""
    most = np.maximum.accumulate(fitness)
    better = np.append(True, fitness[1:] > most[:-1])
    return np.maximum.accumulate(np.where(better, np.arange(len(fitness)), 0))


def offspring(
    population: list[np.ndarray],
    score: np.ndarray,
    pool: np.ndarray,
    k: int,
    rng: np.random.Generator,
    settings: GeneticSettings,
) -> np.ndarray:
    """Make (k,) ascending frames of one child by tournament, crossover and mutation (Appendix
    A.2)."""
    parents = []
    for _ in range(2):
        entrants = rng.choice(len(score), size=min(settings.tournament, len(score)), replace=False)
        parents.append(population[entrants[np.argmax(score[entrants])]])
    child, second = parents
    if rng.random() < settings.crossover:
        child = rng.choice(np.union1d(child, second), size=k, replace=False)
    if rng.random() < settings.mutation:
        child = rng.permutation(child)
        replaced = max(2, k // 5)
        child = np.concatenate([child[replaced:], rng.choice(pool, size=min(replaced, k))])
    return _filled(child, pool, k, rng)


def _filled(subset: np.ndarray, pool: np.ndarray, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return exactly k distinct frames: gaps are filled at random from the pool."""
    distinct = np.unique(subset)
    if len(distinct) < k:
        rest = np.setdiff1d(pool, distinct)
        extra = rng.choice(rest, size=k - len(distinct), replace=False)
        distinct = np.union1d(distinct, extra)
    return distinct


def random_search(
    evaluate: Evaluate, pool: np.ndarray, k: int, evaluations: int, rng: np.random.Generator
) -> SearchResult:
    """Evaluate distinct random subsets, fewer only where the pool has no more to meet."""
    _check_size(k, pool)
    archive = _Archive(evaluate)
    for _ in range(4 * evaluations):
        if len(archive) == evaluations:
            break
        archive.row(rng.choice(pool, size=k, replace=False), 0)
    return archive.result()


def _check_size(k: int, pool: np.ndarray) -> None:
    if not 1 <= k <= len(pool):
        raise ValueError(f"a subset of {k} frames cannot be drawn from a pool of {len(pool)}")


def searched(
    evaluate: Evaluate,
    problem: Problem,
    split: Split,
    search: Mapping[str, Any],
    rng: np.random.Generator,
) -> SearchResult:
    """Search a problem's candidates as a configuration's `search` asks for it (paper, section 3.4),
    with metrics on the proxies."""
    centers, k = problem.capture.centers, search["k"]
    settings = GeneticSettings(**{own.name: search[own.name] for own in fields(GeneticSettings)})
    return genetic_search(evaluate, split.candidates, split.region, centers, k, rng, settings)


def search_table(
    result: SearchResult, stored: int, metrics: Metrics = METRICS
) -> dict[str, np.ndarray]:
    """Return one row a distinct subset, in the order of evaluation; `rank` 0 is the fittest, and -1
    are those beyond the `stored` fittest."""
    rank = np.full(len(result.subsets), -1)
    rank[result.best(stored)] = np.arange(min(stored, len(rank)))
    table = {"generation": result.generation, "subset": result.subsets}
    table |= zip(metrics, result.metrics.T, strict=True)
    return {**table, "fitness": result.fitness, "rank": rank}
