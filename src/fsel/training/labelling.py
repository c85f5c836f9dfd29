"""The search that labels a problem, as the config asks for it, and its table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.metrics import METRICS, Metrics
from fsel.selectors.baselines.nearest import nearest
from fsel.training.search import (
    Evaluate,
    GeneticSettings,
    SearchResult,
    genetic_search,
    random_search,
    swap_search,
)

GENETIC = tuple(field.name for field in fields(GeneticSettings))

Labeller = Callable[
    [Evaluate, Problem, Split, Mapping[str, Any], np.random.Generator], SearchResult
]


def _genetic(evaluate, problem, split, search, rng) -> SearchResult:
    """Run the paper's search (Appendix A.2)."""
    pool, centers = split.candidates, problem.capture.centers
    settings = GeneticSettings(**{key: search[key] for key in GENETIC})
    return genetic_search(evaluate, pool, split.region, centers, search["k"], rng, settings)


def _swap(evaluate, problem, split, search, rng) -> SearchResult:
    """Search by hill climbing from the nearest frames."""
    pool = split.candidates
    starts = [nearest(problem, pool, search["k"])]
    return swap_search(evaluate, pool, starts, search["evaluations"], rng)


def _random(evaluate, problem, split, search, rng) -> SearchResult:
    return random_search(evaluate, split.candidates, search["k"], search["evaluations"], rng)


LABELLERS: dict[str, Labeller] = {"genetic": _genetic, "swap": _swap, "random": _random}
"""Searches of the candidates for subsets of search["k"] frames, by the config's `search.labeller`.

They take (K,) frames -> (3,) metrics on the proxies; the problem; its split, whose region feeds the
genetic search's first population; the config's section `search`; and the only source of chance.
"""


def searched(
    evaluate: Evaluate,
    problem: Problem,
    split: Split,
    search: Mapping[str, Any],
    seeds: Sequence[int],
    metrics: Metrics = METRICS,
) -> dict[str, np.ndarray]:
    """Search one problem's subsets (paper, section 3.4) and return their `search_table`.

    Args:
        evaluate: (K,) frames -> (3,) `metrics` on the proxies.
        search: the config's section of that name.
        seeds: of the search: the scene's and the coverage.
    """
    rng = np.random.default_rng(seeds)
    result = LABELLERS[search["labeller"]](evaluate, problem, split, search, rng)
    return search_table(result, search["stored"], metrics)


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
