"""The search that labels a problem, as the config's section `search` asks for it, and its table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.metrics import METRICS, Metrics
from fsel.training.search import Evaluate, GeneticSettings, SearchResult, genetic_search

GENETIC = tuple(field.name for field in fields(GeneticSettings))


def searched(
    evaluate: Evaluate,
    problem: Problem,
    split: Split,
    search: Mapping[str, Any],
    rng: np.random.Generator,
) -> SearchResult:
    """Search a problem's candidates for subsets of `search["k"]` frames (paper, section 3.4).

    `evaluate` maps (K,) frames to (3,) metrics on the proxies.
    """
    centers, k = problem.capture.centers, search["k"]
    settings = GeneticSettings(**{key: search[key] for key in GENETIC})
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
