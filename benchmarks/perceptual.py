"""GMSD against LPIPS (AlexNet): how subsets of a search rank by either, and what each costs.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/perceptual.py FOLDER...

Each folder is a scene of a run, with its first draw, as results/dl3dv/evaluation00. A genetic
search of 20 frames meets some hundred subsets; all are measured on the proxies by both. Prints
Spearman's rho between the two distances, between PSNR and LPIPS, and between the fitness with
either; the rank by LPIPS's fitness of the subset that is fittest by GMSD's; and processor
milliseconds a view. LPIPS's weights are to be in downloads/ or the user's cache, see
docs/reconstructors.md.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import torch
from scipy.stats import spearmanr

from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import METRICS, score_views
from fsel.reconstruct import reconstructor_of
from fsel.training.labelling import LABELLERS
from fsel.training.search import fitness

SEARCH = {
    "k": 20,
    "population": 20,
    "farthest": 8,
    "uniform": 6,
    "generations": 6,
    "elites": 2,
    "tournament": 4,
    "crossover": 0.8,
    "mutation": 0.3,
}
REPEATS = 20


def searched(folder: Path) -> tuple[np.ndarray, Evaluator]:
    """(n, 4) PSNR, SSIM, GMSD and LPIPS of every subset that a search meets, and its evaluator."""
    split = folder / "draw0" / "split.parquet"
    problem, parts = Problem.load(folder, split), Split.load(split)
    reconstructor = reconstructor_of(
        problem.capture, {"name": "splats", "long_side": 64, "settings": {}}
    )
    evaluator = Evaluator.on_frames(reconstructor, parts.proxies, metrics=[*METRICS, "lpips"])
    rows = []

    def on_proxies(subset: np.ndarray) -> np.ndarray:
        rows.append(evaluator(subset))
        return rows[-1][:3]

    LABELLERS["genetic"](on_proxies, problem, parts, SEARCH, np.random.default_rng(0))
    return np.array(rows), evaluator


def milliseconds(evaluator: Evaluator, metrics: tuple[str, ...]) -> float:
    """Of the processor a view, once the truth's features are there."""
    truth = evaluator.truth
    rendered = (truth[::-1] / np.float32(255)).astype(np.float32)
    score_views(rendered, truth, metrics=metrics)
    started = time.process_time()
    for _ in range(REPEATS):
        score_views(rendered, truth, metrics=metrics)
    return (time.process_time() - started) / REPEATS / len(truth) * 1e3


def main() -> None:
    torch.set_num_threads(1)
    for folder in map(Path, sys.argv[1:]):
        rows, evaluator = searched(folder)
        psnr, _, gmsd, lpips = rows.T
        by_gmsd, by_lpips = fitness(rows[:, :3]), fitness(rows[:, [0, 1, 3]])
        rank = int((by_lpips > by_lpips[by_gmsd.argmax()]).sum()) + 1
        height, width = evaluator.truth.shape[1:3]
        print(
            f"{folder.parent.name}/{folder.name}: {len(rows)} subsets; rho GMSD, LPIPS "
            f"{spearmanr(gmsd, lpips).statistic:.2f}; PSNR, LPIPS "
            f"{-spearmanr(psnr, lpips).statistic:.2f}; fitness "
            f"{spearmanr(by_gmsd, by_lpips).statistic:.2f}; fittest by GMSD is number {rank}; "
            f"{width}x{height}: {milliseconds(evaluator, METRICS):.2f} ms a view, "
            f"LPIPS {milliseconds(evaluator, ('lpips',)):.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
