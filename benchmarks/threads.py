"""Milliseconds of a step of `gaussians` by threads, and whether the models are the same.

    python benchmarks/threads.py [--threads 1 2] [--repeats 8] [--steps 8]

In one process, the numbers of threads in turn: each goes through the same training, and the best of
its medians counts, since others may use the machine.
"""

import argparse
import time

import numpy as np
from reconstructors import generated

import fsel
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.gaussians.training import Training

SIZES = ((128, 6000, 30), (640, 60_000, 12))  # pixels, Gaussians, frames


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=8)
    parser.add_argument("--steps", type=int, default=8)
    arguments = parser.parse_args()
    for width, budget, frames in SIZES:
        bound = Gaussians(generated("mipnerf360", 0, width, frames), gaussians=budget)
        start = bound._start(bound.capture)
        trained = {n: Training(bound.capture, start, bound.settings) for n in arguments.threads}
        best = dict.fromkeys(trained, np.inf)
        for repeat in range(arguments.repeats):
            for count, training in trained.items():
                fsel.set_threads(count)
                times = [time.perf_counter()]
                for step in range(arguments.steps):
                    training.step(repeat * arguments.steps + step)
                    times.append(time.perf_counter())
                best[count] = min(best[count], float(np.median(np.diff(times))))
        same = len({training.table.tobytes() for training in trained.values()}) == 1
        cells = [f"{n} threads {1e3 * seconds:.2f} ms" for n, seconds in best.items()]
        print(f"{width} px, {budget} Gaussians, same bytes {same}: {', '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
