"""The tests of compiled functions, compiled for several kinds of processor.

    python tools/processors.py [--jobs 2] [KIND ...]

Each kind runs in a process of its own, with machine code of its own, kept in `.numba`. Kinds whose
instructions this machine lacks are left out by name. Exits with 1 where a test fails.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from llvmlite import binding

ROOT = Path(__file__).resolve().parent.parent
AVX512 = {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"}
# a processor that LLVM knows -> what a machine needs to run its code; all tests run as `haswell`
KINDS = {
    "generic": set[str](),
    "skylake-avx512": AVX512,
    "znver4": AVX512 | {"avx512bf16", "avx512vbmi2", "gfni", "sse4a", "vaes"},
}
TESTS = (
    "tests/metrics/test_metrics.py",
    "tests/selectors/baselines/test_covisibility.py",
    "tests/selectors/baselines/test_splat_views.py",
    "tests/reconstruct/gaussians/test_optimisation.py",
    "tests/reconstruct/gaussians/test_rendering.py",
    "tests/reconstruct/radiance_field/test_grid.py",
    "tests/reconstruct/radiance_field/test_rays.py",
    "tests/reconstruct/radiance_field/test_space.py",
    "tests/reconstruct/splats",
    "tests/selectors/test_greedy.py",
    "tests/synthetic/test_hierarchy.py",
)


def runnable(kinds: list[str], features: dict[str, bool]) -> list[str]:
    """Those of some kinds whose code runs on a machine of some features."""
    here = {name for name, there in features.items() if there}
    return [kind for kind in kinds if KINDS[kind] <= here]


def tested(kind: str) -> tuple[bool, str]:
    """Run the tests as compiled for a kind; whether they pass, and what they print."""
    environment = os.environ | {
        "NUMBA_CPU_NAME": kind,
        "NUMBA_CPU_FEATURES": "",  # no feature but the kind's own
        "NUMBA_CACHE_DIR": str(ROOT / ".numba" / kind),
        "OMP_NUM_THREADS": "1",
    }
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *TESTS]
    started = time.monotonic()
    ran = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    last = (ran.stdout.strip().splitlines() or ["no output"])[-1].strip("= ")
    print(f"{kind}: {last}, {time.monotonic() - started:.0f} s with what compiles", flush=True)
    return ran.returncode == 0, ran.stdout + ran.stderr


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("kinds", nargs="*", metavar="KIND")
    options = parser.parse_args()
    named = options.kinds or list(KINDS)
    kinds = runnable(named, dict(binding.get_host_cpu_features()))
    for kind in named:
        if kind not in kinds:
            print(f"{kind}: left out, this machine cannot run its code")
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = list(pool.map(tested, kinds))
    failed = [output for passed, output in outcomes if not passed]
    print(*failed, sep="\n", end="")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
