"""Seconds and memory of reconstruction from ever more frames, and of selecting them (Table 5)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_table
from fsel.core.problem import Problem
from fsel.core.programs import FINISHED, Unfinished
from fsel.core.split import Split
from fsel.evaluation.measuring import Run, learned_runs, picks_at, rng_by_name
from fsel.evaluation.summary import ALL_FRAMES
from fsel.experiments.studies.footprint import measure_alone
from fsel.experiments.studies.selection_time import descriptor_seconds, select_once, timed
from fsel.metrics import Metrics

logger = logging.getLogger(__name__)

VARIANTS = ("less_is_more", "less_is_more_no_appearance", "less_is_more_geometry")
UNITS = {"fit_seconds": "s", "render_seconds": "s", "peak_bytes": "bytes"}
ENDED = ["device", "outcome"]


def costs_alone(
    folder: File,
    subsets: Mapping[int, np.ndarray],
    targets: np.ndarray,
    reconstruction: Mapping,
    metrics: Metrics = ("psnr",),
    **limits: Any,
) -> pd.DataFrame:
    """Measure quality, seconds and memory of reconstructions, each in a process of its own.

    Args:
        subsets: k (`ALL_FRAMES` for all) -> frames.
        targets, metrics, limits: see `measure_alone`.

    Returns:
        k, the metrics, the columns of `UNITS`, device, outcome; numbers are NaN where a
        reconstruction did not finish.
    """
    rows = []
    for k, frames in subsets.items():
        try:
            cost = measure_alone(folder, frames, targets, reconstruction, metrics=metrics, **limits)
        except Unfinished as end:
            logger.warning("%s", end)
            cost = {"outcome": end.outcome}
        rows.append({"k": k, "device": "", "outcome": FINISHED, **cost})
        logger.info("%s", rows[-1])
    numbers = [*metrics, *UNITS]
    table = pd.DataFrame(rows, columns=["k", *numbers, *ENDED])
    return table.astype(dict.fromkeys(numbers, float))


def cost_means(costs: Files, metrics: Metrics = ()) -> pd.DataFrame:
    """Return by k the metrics, seconds (fit and rendering), peak_mb, n (scenes), device, outcome.

    Means are NaN where a reconstruction of a scene did not finish; the outcome says why.

    Args:
        costs: `costs_alone`, one a scene.
    """
    table = pd.concat([read_table(path) for path in costs])
    table["seconds"] = table["fit_seconds"] + table["render_seconds"]
    table["peak_mb"] = table["peak_bytes"] / 1e6
    groups = table.groupby("k", sort=False)
    means = groups[[*metrics, "seconds", "peak_mb"]].agg(lambda values: values.mean(skipna=False))
    return means.assign(n=groups.size(), **{name: groups[name].max() for name in ENDED})


def measure_costs(
    folder: File,
    split: File,
    weights: Files,
    costs: File,
    times: File,
    *,
    budgets: Sequence[int],
    appearance: Mapping,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what reconstruction from ours costs at every budget, and what selecting does.

    Args:
        weights: one scorer of each variant: ours, and ours denied some features.
        costs: receives `costs_alone`, `ALL_FRAMES` being all candidates.
        times: receives variant, k, seconds: descriptors of all observed frames, where the variant
            reads them, and the selection.
    """
    problem, targets = Problem.load(folder, split), Split.load(split).targets
    variants = {run.method.name: run for run in learned_runs(weights)}
    picks = picks_at(problem, variants[VARIANTS[0]], budgets, rng_by_name(0))
    subsets = {made.k: made.frames for made in picks} | {ALL_FRAMES: problem.candidates}
    measured = costs_alone(folder, subsets, targets, reconstruction)
    write_table(measured, costs, units=UNITS, config=config)
    seconds = selection_seconds(problem, variants, budgets, appearance)
    write_table(seconds, times, units={"seconds": "s"}, config=config)


def selection_seconds(
    problem: Problem, variants: Mapping[str, Run], budgets: Sequence[int], appearance: Mapping
) -> pd.DataFrame:
    """Return variant, k, seconds of one thread; see `measure_costs`."""
    images = np.asarray(problem.capture.images[problem.observed])
    a_pool = descriptor_seconds(images, appearance)
    rows = []
    for name, run in variants.items():
        before = sum(a_pool[read] for read in run.method.reads)
        for k in budgets:
            select_once(problem, run, k)  # compiles
            rows.append((name, k, before + timed(partial(select_once, problem, run, k))))
    return pd.DataFrame(rows, columns=["variant", "k", "seconds"])
