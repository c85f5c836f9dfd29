"""Seconds and memory of reconstruction from ever more frames, and of selecting them (Table 5)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd

from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.measuring import Run, chance, learned_runs, picks_at
from fsel.experiments import specs
from fsel.experiments.studies.footprint import measure_alone
from fsel.experiments.studies.selection_time import descriptor_seconds, select_once, timed
from fsel.report.summary import ALL_FRAMES
from fsel.utils.files import File, Files, read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)

VARIANTS = ("less_is_more", "less_is_more_no_appearance", "less_is_more_geometry")
UNITS = {
    "fit_seconds": "s, of the processor",
    "render_seconds": "s, of the processor",
    "peak_bytes": "bytes",
}


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
        costs: receives k (`ALL_FRAMES` for all candidates) and the columns of `UNITS`.
        times: receives variant, k, seconds: descriptors of all observed frames, where the variant
            reads them, and the selection.
    """
    problem, targets = Problem.load(folder, split), Split.load(split).targets
    variants = {run.method.name: run for run in learned_runs(weights)}
    picks = picks_at(problem, variants[VARIANTS[0]], budgets, chance(0))
    chosen = {made.k: made.frames for made in picks} | {ALL_FRAMES: problem.candidates}
    rows = []
    for k, frames in chosen.items():
        cost = measure_alone(folder, frames, targets, reconstruction)
        rows.append({"k": k, **{name: cost[name] for name in UNITS}})
        logger.info("%s", rows[-1])
    write_table(pd.DataFrame(rows), costs, units=UNITS, config=config)
    seconds = selection_seconds(problem, variants, budgets, appearance)
    write_table(seconds, times, units={"seconds": "s"}, config=config)


def selection_seconds(
    problem: Problem, variants: Mapping[str, Run], budgets: Sequence[int], appearance: Mapping
) -> pd.DataFrame:
    """Table of variant, k, seconds of one thread; see `measure_costs`."""
    images = np.asarray(problem.capture.images[problem.observed])
    a_pool = descriptor_seconds(images, appearance)
    rows = []
    for name, run in variants.items():
        before = sum(a_pool[read] for read in run.method.reads)
        for k in budgets:
            select_once(problem, run, k)  # compiles
            rows.append((name, k, before + timed(partial(select_once, problem, run, k))))
    return pd.DataFrame(rows, columns=["variant", "k", "seconds"])


def mean_costs(costs: Files) -> pd.DataFrame:
    """Table by k of seconds (fit and rendering) and peak_mb: means over scenes.

    Args:
        costs: what `measure_costs` wrote, one a scene.
    """
    table = pd.concat([read_table(path) for path in costs])
    table["seconds"] = table["fit_seconds"] + table["render_seconds"]
    table["peak_mb"] = table["peak_bytes"] / 1e6
    return table.groupby("k")[["seconds", "peak_mb"]].mean()


def _first_scorers(experiment: Experiment) -> list[str]:
    """The first seed of each variant that is trained here."""
    return [inputs.scorer_files(experiment, name)["weights"][0] for name in VARIANTS]


MEASURED = Job(
    measure_costs,
    outputs={
        "costs": f"{inputs.SCENE}/{{reconstructor}}costs.parquet",
        "times": f"{inputs.SCENE}/{{reconstructor}}times.parquet",
    },
    message="Measuring time and memory on {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: {
        **specs.of_draw("split", draw="draw0", kinds=inputs.DESCRIBED),
        "weights": _first_scorers(experiment),
    },
    params=lambda experiment: {
        "budgets": experiment.config["budgets"],
        "appearance": experiment.config["appearance"],
        "reconstruction": experiment.reconstruction_of,
    },
    size=Size(4000, 30, "reconstruction"),
)
