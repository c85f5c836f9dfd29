"""What picks are worth under `splats` and under `gaussians` on captures from disk, and fewer frames
against all.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/judged_picks.py picks FOLDER...
    ... python benchmarks/judged_picks.py fewer FOLDER...
    ... python benchmarks/judged_picks.py auto FOLDER... --long-side 128 --steps 600 \
        --gaussians 6000

`picks`: PSNR on held-out targets of a region for several selectors, a line a fit; means at the end.
`fewer`: the picks of `fsel` at several budgets and all frames, at several numbers of steps.
`auto`: the picks of `-k auto --targets every:8`, and of shares of its number, over two seeds; rows
of captures that the file has are not measured again.
Seconds are the processor's.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import pandas as pd

import fsel
from fsel.captures.images.sharpness import sharpness
from fsel.core.capture import Capture
from fsel.core.problem import Problem, checked_select
from fsel.core.split import coverage_split
from fsel.evaluation.numbers import read_csv, write_csv
from fsel.metrics import score_views
from fsel.reconstruct import RECONSTRUCTORS
from fsel.selection.api import described
from fsel.selection.problem import request_problem
from fsel.selection.targets import targets_of

SHARES = (0.4, 0.6, 1.0, 1.6, 2.5)  # of the number that -k auto finds
METHODS = ("uniform", "fvs", "kmedoids", "nearest", "fsel")


def problem_of(capture: Capture, coverage: int, draw: int) -> tuple[Problem, np.ndarray]:
    """The problem of a draw of targets in a region, and the targets; the others may be picked."""
    held_out = coverage_split(capture, coverage, draw).targets
    targets = targets_of(capture, held_out.tolist())
    measured = sharpness(capture.images)
    return request_problem(capture, targets, measured, None, described(capture)), held_out


def picked(problem: Problem, method: str, k: int) -> np.ndarray:
    """(k,) frames, ascending."""
    rng = np.random.default_rng(0)
    return np.sort(checked_select(fsel.METHODS[method], problem, k, rng))


def fitted(
    capture: Capture, name: str, frames: np.ndarray, held_out: np.ndarray, **settings
) -> tuple[float, float, float]:
    """Mean PSNR on held-out frames and on ten of the given ones, and the seconds of the fit."""
    started = time.process_time()
    model = RECONSTRUCTORS[name](capture, **settings).fit(frames)
    seconds = time.process_time() - started
    shown = frames[:: max(1, len(frames) // 10)]
    scores = []
    for which in (held_out, shown):
        truth = np.asarray(capture.images[which])
        scores.append(float(score_views(model.render(capture.view(which)), truth)[:, 0].mean()))
    return scores[0], scores[1], seconds


def picks(capture: Capture, options: argparse.Namespace) -> None:
    """Every selector under both reconstructors."""
    judges = {
        "splats": {},
        "gaussians": {"steps": options.steps[0], "gaussians": options.gaussians},
    }
    values = defaultdict(list)
    for draw in range(options.draws):
        problem, held_out = problem_of(capture, options.coverage, draw)
        for k in options.frames:
            for method in options.methods:
                frames = picked(problem, method, k)
                for judge, settings in judges.items():
                    beyond, within, seconds = fitted(capture, judge, frames, held_out, **settings)
                    values[k, method, judge].append(beyond)
                    print(
                        f"{capture.source}, draw {draw}, K = {k}, {method}, {judge}: held-out "
                        f"{beyond:.2f} dB, training {within:.2f} dB, {seconds:.1f} s",
                        flush=True,
                    )
    for (k, method, judge), scores in values.items():
        print(f"{capture.source}, mean, K = {k}, {method}, {judge}: {np.mean(scores):.2f} dB")


def fewer(capture: Capture, options: argparse.Namespace) -> None:
    """The picks of `fsel`, and all frames, at each number of steps."""
    problem, held_out = problem_of(capture, options.coverage, 0)
    subsets = {str(k): picked(problem, "fsel", k) for k in options.frames}
    subsets["all"] = problem.observed
    for steps in options.steps:
        for k, frames in subsets.items():
            settings = {"steps": steps, "gaussians": options.gaussians}
            beyond, within, seconds = fitted(capture, "gaussians", frames, held_out, **settings)
            print(
                f"{capture.source}, {steps} steps, K = {k} ({len(frames)}): held-out {beyond:.2f} "
                f"dB, training {within:.2f} dB, {seconds:.1f} s",
                flush=True,
            )


def auto(capture: Capture, options: argparse.Namespace) -> None:
    """Numbers of frames around the one that is found, on one frame in eight, held out."""
    name = Path(capture.source).name
    table = read_csv(options.out) if options.out.is_file() else pd.DataFrame(columns=["capture"])
    if name in table["capture"].values:
        return
    found = len(fsel.select(capture, "auto", targets="every:8"))
    held_out = np.arange(0, len(capture), 8)
    rows = []
    for share in SHARES:
        k = min(round(share * found), len(capture) - len(held_out))
        frames = fsel.select(capture, k, targets="every:8").indices
        settings = {"steps": options.steps[0], "gaussians": options.gaussians}
        fits = [
            fitted(capture, "gaussians", np.sort(frames), held_out, **settings, seed=seed)
            for seed in range(2)
        ]
        psnr = np.mean([beyond for beyond, _, _ in fits])
        rows.append({"capture": name, "frames": len(capture), "share": share, "k": k, "psnr": psnr})
        print(rows[-1], flush=True)
    measured = pd.DataFrame(rows)
    measured["gain"] = measured["psnr"] - measured["psnr"][SHARES.index(1.0)]
    options.out.parent.mkdir(parents=True, exist_ok=True)
    known = [*table.to_dict("records"), *measured.to_dict("records")]
    write_csv(pd.DataFrame(known), options.out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("what", choices=("picks", "fewer", "auto"), help="see above")
    parser.add_argument("folders", nargs="+", help="captures on disk")
    parser.add_argument("--steps", type=int, nargs="+", default=[800])
    parser.add_argument("--gaussians", type=int, default=10_000)
    parser.add_argument("--long-side", type=int, default=256, help="pixels")
    parser.add_argument("--frames", type=int, nargs="+", default=[15, 30])
    parser.add_argument("--draws", type=int, default=2, help="of targets, `picks` alone")
    parser.add_argument("--methods", nargs="+", default=METHODS, help="`picks` alone")
    parser.add_argument("--coverage", type=int, default=40, help="%% of the capture: the targets'")
    out = Path("results/tables/budget_captures.csv")
    parser.add_argument("-o", "--out", type=Path, default=out, help="csv of `auto`")
    options = parser.parse_args()
    for folder in options.folders:
        globals()[options.what](fsel.read_capture(folder, long_side=options.long_side), options)


if __name__ == "__main__":
    main()
