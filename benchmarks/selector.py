"""Time the greedy selector, features given: K = 30 from 130 to 100,000 candidates.

`fsel` is its linear rule on the inputs that it reads; a network is a fresh one on all inputs.
`reference` is the loop without a compiler, which the command uses for small pools; `features` is
what the rule needs computed before the first pick. Prints medians of the processor's time, and peak
memory above what the inputs take. Baselines are timed by the rule `speed_error`.

    OMP_NUM_THREADS=1 python benchmarks/selector.py
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.core.capture import Capture
from fsel.core.problem import Problem
from fsel.features.columns import FOLLOWING_INPUTS, INPUTS
from fsel.features.conditioned import NOTHING
from fsel.selectors import greedy, pretrained, reference_loop
from fsel.selectors.greedy import Prepared, Rows
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import SHAPES, Network

BOUNDS = {130: 3.0, 1_000: 15.0, 10_000: 120.0}  # milliseconds, of a network
AIMS = {130: 1.0, 1_000: 4.0, 10_000: 10.0}  # those of `fsel`
POOLS = (*BOUNDS, 100_000)
K, VIEWS, DESCRIPTOR = 30, 15, 176
ONCE = 2.0  # seconds from which on a call is not repeated


def unit_rows(rng: np.random.Generator, n: int, width: int) -> np.ndarray:
    """(n, width) random unit vectors."""
    rows = rng.normal(size=(n, width))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def prepared_of(n: int, rng: np.random.Generator) -> Prepared:
    """A problem of n random candidates with every input in use."""
    static = rng.normal(size=(n, INPUTS))
    static[:, FOLLOWING_INPUTS] = 0
    rows = Rows(
        centers=rng.normal(size=(n, 3)),
        axes=unit_rows(rng, n, 3),
        bearings=unit_rows(rng, n, 3),
        descriptors=unit_rows(rng, n, DESCRIPTOR).astype(np.float32),
        closeness=rng.random((n, VIEWS)),
        look_embedding=0.1 * rng.normal(size=(n, 6)),
        visible=NOTHING,
    )
    return Prepared(pool=np.arange(n), static=static, rows=rows)


def read_by_fsel(prepared: Prepared, problem: Problem) -> Prepared:
    """The same problem less the inputs that `fsel` does not read, with what the frames of another
    see of its views."""
    visible = POLICIES["fsel"].prepare(problem).rows.visible
    rows = prepared.rows._replace(descriptors=prepared.rows.descriptors[:, :0], visible=visible)
    return replace(prepared, static=np.zeros_like(prepared.static), rows=rows)


def problem_of(n: int, rng: np.random.Generator) -> Problem:
    """A problem of n random cameras to prepare for `fsel`; no image is read."""
    turned = Rotation.random(n + VIEWS, rng=rng).as_matrix()
    capture = Capture(
        names=tuple(f"{i:06d}" for i in range(n + VIEWS)),
        world_to_camera=np.concatenate([turned, rng.normal(size=(n + VIEWS, 3, 1))], axis=2),
        intrinsics=np.tile([6.0, 6.0, 4.0, 3.0], (n + VIEWS, 1)),
        images=np.zeros((n + VIEWS, 6, 8, 3), np.uint8),
        sequences=("a",) * (n + VIEWS),
        source="a benchmark",
    )
    return Problem(
        capture=capture,
        candidates=np.arange(n),
        proxies=np.arange(VIEWS),
        targets=capture.view(np.arange(n, n + VIEWS)),
        descriptors=np.zeros((n + VIEWS, 0), np.float32),
        sharpness=np.zeros(n + VIEWS),
    )


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


def calls(
    prepared: Prepared, read: Prepared, problem: Problem, fresh: Network
) -> dict[str, Callable[[], object]]:
    """What is timed, by name."""
    rule = pretrained.method().scorer
    return {
        "fsel": lambda: greedy.greedy(read, rule, K),
        "fsel, reference": lambda: reference_loop.greedy(read, rule, K),
        "fsel, features": lambda: POLICIES["fsel"].prepare(problem),
        "a network": lambda: greedy.greedy(prepared, fresh, K),
        "a network, reference": lambda: reference_loop.greedy(prepared, fresh, K),
    }


def main() -> None:
    """Print a row a method: milliseconds and MiB a pool."""
    rng = np.random.default_rng(0)
    fresh = Network(
        {
            name: rng.uniform(-1, 1, shape).astype(np.float32) / np.float32(np.sqrt(shape[-1]))
            for name, shape in SHAPES.items()
        }
    )
    prepared, problem = prepared_of(K + 5, rng), problem_of(K + 5, rng)
    for call in calls(prepared, read_by_fsel(prepared, problem), problem, fresh).values():
        call()  # compiles
    cells_of: dict[str, dict[int, tuple[float, float]]] = {}
    for pool in POOLS:
        prepared, problem = prepared_of(pool, rng), problem_of(pool, rng)
        read = read_by_fsel(prepared, problem)
        for name, call in calls(prepared, read, problem, fresh).items():
            cells_of.setdefault(name, {})[pool] = measured(call)
        pairs = ((prepared, fresh), (read, pretrained.method().scorer))
        picks = [[loop.greedy(*pair, 5)[0] for loop in (greedy, reference_loop)] for pair in pairs]
        same = all(np.array_equal(*both) for both in picks)
        bound, aim = (limits.get(pool, np.nan) for limits in (BOUNDS, AIMS))
        print(f"{pool} candidates: bounds {bound:.0f} ms, {aim:.0f} of fsel; same picks: {same}")
    print(f"{'ms (MiB)':22s}" + "".join(f"{pool:>18,d}" for pool in POOLS) + "")
    for name, cells in cells_of.items():
        texts = [f"{ms:.1f} ({mib:.0f})" for ms, mib in cells.values()]
        print(f"{name:22s}" + "".join(f"{text:>18s}" for text in texts))


if __name__ == "__main__":
    main()
