"""Search an evaluation problem, to compare selection with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from fsel.core.files import File, fingerprint, repeated, stacked, write_table
from fsel.core.names import name_seed
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation import measuring
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import Metrics, units
from fsel.reconstruct import reconstructor_of
from fsel.training.journal import Journal
from fsel.training.search import random_search, search_table, searched

SEARCHES = ("search", "random_search")


def search_oracle(
    folder: File,
    split: File,
    subsets: File,
    oracle: File,
    *,
    search: Mapping,
    reconstruction: Mapping,
    fitness: Metrics,
    metrics: Metrics,
    seed: int,
    inputs: Iterable[File],
    config: str,
    library: str = "",
) -> None:
    """Run the genetic search on an evaluation problem, and random search of equal budget beside it.

    Both score subsets on the proxies and are then measured on the targets (Appendix D.3).

    Args:
        subsets, oracle: receive every subset, on the proxies, and the best two, on the targets.
        fitness: PSNR, SSIM and a perceptual distance of the registry, or name -> settings.
    """
    problem, parts = Problem.load(folder, split), Split.load(split)
    reconstructor = reconstructor_of(problem.capture, reconstruction)
    on_targets = Evaluator.on_frames(reconstructor, parts.targets, metrics=metrics)
    evaluator = Evaluator.on_frames(reconstructor, parts.proxies, metrics=fitness)
    searches, picks = [], []
    with Journal(subsets, fingerprint(inputs, {"config": config, "library": library})) as journal:
        on_proxies = journal.remember("p", evaluator)
        rngs = {name: np.random.default_rng([seed, name_seed(name)]) for name in SEARCHES}
        found = searched(on_proxies, problem, parts, search, rngs["search"])
        size = search["k"], len(found.subsets)
        chance = random_search(on_proxies, parts.candidates, *size, rngs["random_search"])
        for name, result in zip(SEARCHES, (found, chance), strict=True):
            table = search_table(result, search["stored"], fitness)
            searches.append(table | repeated({"method": name}, len(table["rank"])))
            fittest = result.subsets[result.best(1)[0]]
            head = {"method": name, "seed": 0, "k": search["k"]}
            picks.append(repeated(head, len(fittest)) | {"frame": fittest})
        measured = measuring.measure(on_targets, stacked(picks))
        write_table(measured, oracle, units=measuring.measured_units(metrics), config=config)
        write_table(stacked(searches), subsets, units=units(fitness), config=config)
