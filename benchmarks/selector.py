"""Time the greedy selector, features given: K = 30 from 130 to 100,000 candidates.

Beside it the plain float64 loop, which recomputes every input of every candidate from all picks at
every step, and FVS, DPP and k-medoids on the same cameras and descriptors. Prints medians of the
processor's time, which other work disturbs less than the clock's; the exponent of growth with the
number of candidates from 1,000 on; and peak memory above what the inputs take. k-medoids stops at
10,000: its matrix would take 40 GB at 100,000.

    OMP_NUM_THREADS=1 python benchmarks/selector.py
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fsel.baselines.dpp import greedy_map
from fsel.baselines.kmedoids import distances, fasterpam
from fsel.features.appearance import KERNEL_JITTER
from fsel.features.conditioned import ENOUGH, FEW, GROUP, NOVEL
from fsel.geometry import farthest_views
from fsel.selector import pretrained
from fsel.selector.greedy import DYNAMIC, Prepared, greedy, standardise
from fsel.selector.scorer import SHAPES, Scorer

BOUNDS = {130: 3.0, 1_000: 15.0, 10_000: 100.0}  # milliseconds
POOLS = (*BOUNDS, 100_000)
LARGEST = {"k-medoids": 10_000}
K, VIEWS, DESCRIPTOR = 30, 15, 176
ONCE = 2.0  # seconds from which on a call is not repeated


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
        looks=0.1 * rng.normal(size=(n, 6)),
    )


def spread_of(points: np.ndarray, picks: list[int], free: np.ndarray) -> np.ndarray:
    """(n,) distances to the picks by `fsel.features.conditioned`."""
    gaps = np.stack([np.linalg.norm(points - points[i], axis=1) for i in picks])
    if len(picks) < FEW:
        far = np.sort(gaps, axis=0)[min(len(picks), GROUP) - 1]
    else:
        with np.errstate(divide="ignore"):
            far = (gaps**-2).sum(axis=0) ** -0.5
    return np.minimum(far, ENOUGH * far[free].mean())


def recomputed(prepared: Prepared, weights: dict[str, np.ndarray], k: int) -> np.ndarray:
    """The picks of a loop that keeps nothing from one step to the next."""
    scorer, picks = Scorer(weights, {}), []
    described = prepared.descriptors.astype(np.float64)
    while len(picks) < k:
        free = np.ones(len(prepared.pool), bool)
        free[picks] = False
        inputs = prepared.static.copy()
        covered = prepared.kernel[picks].sum(axis=0)
        looks = prepared.looks.reshape(-1, 2, 3)
        apart = [np.linalg.norm(looks - looks[i], axis=2).sum(axis=1) for i in picks]
        novel = np.min([np.full(len(looks), NOVEL), *apart], axis=0) / NOVEL
        inputs[:, DYNAMIC[4]] += (prepared.kernel / (1 + covered)).mean(axis=1) * novel
        if picks:
            spread = [
                spread_of(points, picks, free)
                for points in (prepared.centers, prepared.axes, prepared.bearings)
            ]
            alike = (described @ described[picks].T).max(axis=1)
            columns = np.stack([*spread[:2], alike, spread[2]], axis=1)
            inputs[:, DYNAMIC[:4]] = standardise(columns, free)
        picks.append(int(np.argmax(np.where(free, scorer.scores(inputs), -np.inf))))
    return np.array(picks)


def measured(call: Callable[[], object]) -> tuple[float, float]:
    """Median milliseconds of five calls, fewer long ones, and peak MiB above the start."""
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak so far
    before, seconds = resident("VmRSS"), []
    while len(seconds) < 5 and sum(seconds) < ONCE:
        start = time.process_time()
        call()
        seconds.append(time.process_time() - start)
    return 1e3 * float(np.median(seconds)), resident("VmHWM") - before


def resident(field: str) -> float:
    """Memory of this process in MiB: now (VmRSS), or at its peak (VmHWM)."""
    text = Path("/proc/self/status").read_text()
    return int(re.search(rf"{field}:\s+(\d+)", text)[1]) / 1024


def kmedoids(prepared: Prepared) -> np.ndarray:
    """k-medoids from a farthest-view start."""
    rows = np.arange(len(prepared.pool))
    start = farthest_views(rows, prepared.centers, K, 0).astype(np.int64)
    return fasterpam(distances(prepared.centers, prepared.axes, prepared.descriptors), start)


def calls(prepared: Prepared, fresh: dict[str, np.ndarray]) -> dict[str, Callable[[], object]]:
    """What is timed, by name."""
    rows, own = np.arange(len(prepared.pool)), pretrained.scorer().weights
    return {
        "fsel, fresh network": lambda: greedy(prepared, fresh, K),
        "fsel, shipped scorer": lambda: greedy(prepared, own, K),
        "plain, fresh network": lambda: recomputed(prepared, fresh, K),
        "FVS": lambda: farthest_views(rows, prepared.centers, K, 0),
        "DPP": lambda: greedy_map(prepared.descriptors.astype(np.float64), KERNEL_JITTER, K),
        "k-medoids": lambda: kmedoids(prepared),
    }


def exponent(pools: list[int], milliseconds: list[float]) -> float:
    """Slope of the logarithms from 1,000 candidates on."""
    large = [i for i, pool in enumerate(pools) if pool >= 1_000]
    logs = np.log([[pools[i], milliseconds[i]] for i in large])
    return float(np.polyfit(*logs.T, 1)[0])


def main() -> None:
    """Print a row a method: milliseconds and MiB a pool, and the exponent."""
    rng = np.random.default_rng(0)
    fresh = {
        name: rng.uniform(-1, 1, shape).astype(np.float32) / np.float32(np.sqrt(shape[-1]))
        for name, shape in SHAPES.items()
    }
    for call in calls(prepared_of(K + 5, rng), fresh).values():
        call()  # compiles
    found: dict[str, dict[int, tuple[float, float]]] = {}
    for pool in POOLS:
        prepared = prepared_of(pool, rng)
        for name, call in calls(prepared, fresh).items():
            if pool <= LARGEST.get(name, pool):
                found.setdefault(name, {})[pool] = measured(call)
        same = np.array_equal(recomputed(prepared, fresh, 5), greedy(prepared, fresh, 5)[0])
        print(f"{pool} candidates: bound {BOUNDS.get(pool, np.nan):.0f} ms; same picks: {same}")
    print(f"{'ms (MiB)':22s}" + "".join(f"{pool:>18,d}" for pool in POOLS) + "  exponent")
    for name, cells in found.items():
        texts = [f"{ms:.1f} ({mib:.0f})" for ms, mib in cells.values()]
        slope = exponent(list(cells), [ms for ms, _ in cells.values()])
        texts += ["--"] * (len(POOLS) - len(texts))
        print(f"{name:22s}" + "".join(f"{text:>18s}" for text in texts) + f"{slope:10.2f}")


if __name__ == "__main__":
    main()
