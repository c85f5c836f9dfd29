"""Fit what `-k auto` predicts by to reconstructions of training scenes, for two rules."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_table, write_text
from fsel.core.problem import Problem
from fsel.core.split import coverage_split
from fsel.evaluation.evaluator import evaluators
from fsel.evaluation.measuring import learned_runs, measure, rng_by_name, select
from fsel.selection.budget import shifts, view_shift

logger = logging.getLogger(__name__)

COUNTS = (4, 6, 8, 10, 13, 16, 20, 25, 30, 40, 50, 60)  # frames reconstructed from
REPEATS = 3  # requests of each coverage
SHIFTS = ["first", "second", "third"]
CURVE = ["scene", "coverage", "repeat"]


def budget_curves(
    folder: File,
    weights: Files,
    curves: File,
    *,
    coverages: Sequence[int],
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure PSNR against the number of frames, for requests of several sizes on one scene.

    Args:
        weights: the scorer that picks.
        curves: receives coverage, repeat, k, psnr, and the mean shifts of
            `fsel.selection.budget.shifts` after k picks.
        coverages: per cent of the capture that targets are drawn from.
    """
    capture, described = Capture.load(folder), read_table(f"{folder}/descriptors.parquet")
    evaluator = evaluators(reconstruction, ("psnr",))
    tables = []
    for coverage, repeat in product(coverages, range(REPEATS)):
        split = coverage_split(capture, coverage, seed + repeat)
        problem = Problem.of(capture, split, described)
        counts = [k for k in COUNTS if k <= len(problem.observed)]
        picks = select(problem, learned_runs(weights)[:1], counts, rng_by_name(seed))
        scores = measure(evaluator(capture, split.targets), picks)
        psnr = pd.DataFrame(scores).groupby("k")["psnr"].mean()
        frames = picks["frame"][picks["k"] == counts[-1]]
        means = shifts(view_shift(capture, frames, capture.view(split.targets)))
        table = pd.DataFrame(means, columns=SHIFTS).loc[psnr.index].assign(psnr=psnr)
        tables.append(table.rename_axis("k").reset_index().assign(coverage=coverage, repeat=repeat))
    write_table(pd.concat(tables), curves, units={"psnr": "dB"}, config=config)


def fit_worth(curves: pd.DataFrame) -> np.ndarray:
    """Return the (3,) dB that a field of view is worth, by non-negative least squares.

    Every curve has an offset of its own: what a scene reaches at best is not predicted. All
    datasets weigh the same.

    Args:
        curves: dataset, scene, and the columns of `budget_curves`.
    """
    columns = [*SHIFTS, "psnr"]
    offset = curves.groupby(["dataset", *CURVE])[columns].transform("mean")
    weight = np.sqrt(1 / curves.groupby("dataset")["psnr"].transform("size").to_numpy())
    centred = (curves[columns] - offset).to_numpy() * weight[:, None]
    return nnls(-centred[:, :-1], centred[:, -1])[0]


def fit_budget(curves: Files, record: File, *, scenes: Sequence[str], config: str) -> None:
    """Fit the prediction to all training scenes.

    Args:
        curves: what `budget_curves` wrote, one a scene.
        record: receives `worth` and its provenance, as JSON.
        scenes: `dataset/scene` of each.
    """
    tables = []
    for name, path in zip(scenes, curves, strict=True):
        dataset, scene = name.split("/")
        tables.append(read_table(path).assign(dataset=dataset, scene=scene))
    every = pd.concat(tables)
    worth = fit_worth(every)
    count = len(every.drop_duplicates(["dataset", *CURVE]))
    made = f"least squares on {count} curves of PSNR against K of {len(scenes)} scenes"
    content = {
        "worth": worth.round(4).tolist(),
        "unit": "dB a field of view, of the closest, second and third frame",
        "provenance": {"made by": made, "config": config},
        "remade by": "make weights",
    }
    write_text(json.dumps(content, indent=2) + "\n", record)
    logger.info("%s: %s", made, worth)
