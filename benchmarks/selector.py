"""Time the greedy selector, features given: K = 30 from 130, 1,000 and 10,000 candidates.

Prints the median of several calls, its bound, the time of the plain float64 loop over the same
inputs, and how many times faster the compiled one is. Run on a quiet machine:

    python benchmarks/selector.py
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable

import numpy as np

from fsel.scorer import SHAPES, Scorer
from fsel.selector import DYNAMIC, Prepared, greedy, run_greedy

BOUNDS = {130: 3.0, 1_000: 15.0, 10_000: 100.0}  # milliseconds
K, VIEWS, DESCRIPTOR = 30, 15, 176


def unit_rows(rng: np.random.Generator, n: int, width: int) -> np.ndarray:
    """(n, width) random unit vectors."""
    rows = rng.normal(size=(n, width))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def prepared_of(n: int, rng: np.random.Generator) -> Prepared:
    """A problem of n random candidates with every input in use."""
    static = rng.normal(size=(n, 19))
    static[:, DYNAMIC] = 0
    return Prepared(
        pool=np.arange(n),
        static=static,
        centers=rng.normal(size=(n, 3)),
        axes=unit_rows(rng, n, 3),
        bearings=unit_rows(rng, n, 3),
        descriptors=unit_rows(rng, n, DESCRIPTOR).astype(np.float32),
        kernel=rng.random((n, VIEWS)),
    )


def plain(prepared: Prepared, weights: dict[str, np.ndarray]) -> np.ndarray:
    """The picks of the uncompiled network in float64, every candidate at every step."""
    scorer = Scorer(weights, {})
    inputs = prepared.static.copy()

    def score(dynamic: np.ndarray) -> np.ndarray:
        inputs[:, DYNAMIC] = dynamic
        return scorer.scores(inputs)

    return run_greedy(prepared, score, K)[0]


def median_milliseconds(call: Callable[[], object], repeats: int) -> float:
    """Median wall time of a call, after one to warm up."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return 1e3 * float(np.median(seconds))


def main() -> None:
    """Print the table, and by how much 10,000 candidates raise the process's memory."""
    rng = np.random.default_rng(0)
    weights = {
        name: rng.uniform(-1, 1, shape).astype(np.float32) / np.float32(np.sqrt(shape[-1]))
        for name, shape in SHAPES.items()
    }
    greedy(prepared_of(K, rng), weights, K)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    problems = {n: prepared_of(n, rng) for n in BOUNDS}
    fast = {
        n: median_milliseconds(lambda p=p: greedy(p, weights, K), 15) for n, p in problems.items()
    }
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print("candidates  compiled ms  bound ms  plain ms  ratio  same picks")
    for n, problem in problems.items():
        slow = median_milliseconds(lambda p=problem: plain(p, weights), 3)
        same = np.array_equal(plain(problem, weights), greedy(problem, weights, K)[0])
        print(f"{n:10d} {fast[n]:12.2f} {BOUNDS[n]:9.0f} {slow:9.1f} {slow / fast[n]:6.1f}  {same}")
    print(f"peak memory over the warm interpreter: {(after - before) / 1024:.0f} MiB")


if __name__ == "__main__":
    main()
