"""Time one evaluation by `splats`, averaged over a whole search with its caches filled on the way.

    OMP_NUM_THREADS=1 python benchmarks/evaluation.py [--repeats 3]

Prints medians over the repeats of milliseconds of the processor, one line a stage, on one thread:
K = 20 frames, 15 proxies, 64x48; the bound is 10 ms.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from reconstructors import generated

from fsel.core.split import evaluation_split
from fsel.metrics import score_views
from fsel.reconstruct.splats import Splats
from fsel.training.search import genetic_search

STAGES = ("fit", "render", "score")


def search(bound: Splats, split, seed: int) -> dict[str, float]:
    """Milliseconds an evaluation of one genetic search, by stage."""
    spent = np.zeros(len(STAGES))
    views = bound.capture.view(split.proxies)
    truth = np.asarray(bound.capture.images[split.proxies])

    def evaluate(subset: np.ndarray) -> np.ndarray:
        marks = [time.process_time()]
        model = bound.fit(subset)
        marks.append(time.process_time())
        images = model.render(views)
        marks.append(time.process_time())
        metrics = score_views(images, truth).mean(axis=0)
        marks.append(time.process_time())
        spent[:] += np.diff(marks)
        return metrics

    rng, centers = np.random.default_rng(seed), bound.capture.centers
    result = genetic_search(evaluate, split.candidates, split.region, centers, 20, rng)
    each = 1e3 * spent / len(result.subsets)
    row = dict(zip(STAGES, each.tolist(), strict=True))
    return row | {"total": each.sum(), "subsets": len(result.subsets)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    made = generated("mipnerf360", 0, width=64)
    split = evaluation_split(made, 0, 0)
    search(Splats(made), split, 0)  # compiles
    rows = []
    for repeat in range(repeats):
        bound = Splats(made)
        row, again = search(bound, split, repeat), search(bound, split, 100 + repeat)
        rows.append(row | {"total, second search": again["total"]})
    for name in rows[0]:
        print(f"{name:22s}{np.median([row[name] for row in rows]):9.2f}")


if __name__ == "__main__":
    main()
