"""Quality, time and memory against the number of frames (paper, Table 5)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd

from fsel.baselines import METHODS
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.measuring import Run, chance, learned_runs, picks_at
from fsel.experiments import specs
from fsel.experiments.studies.footprint import measure_alone
from fsel.experiments.studies.selection_time import select_once, timed
from fsel.features.appearance import descriptors
from fsel.images.sharpness import sharpness
from fsel.report import curves
from fsel.report.captions import note
from fsel.report.numbers import write_csv
from fsel.utils.files import File, Files, read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

SHARES = (0.5, 0.75)  # of the candidates, beyond the budgets
EVERY = "all"
DRAWN = {"less_is_more": "Ours", "uniform": "Uniform"}
UNITS = {
    "psnr": "dB",
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
    """Measure what reconstruction costs from ever more frames, and what selecting them does.

    Args:
        weights: one scorer of each variant: ours, and ours denied some features.
        costs: receives method, step (budget, share of the candidates, or `all`), k, psnr,
            fit_seconds, render_seconds, peak_bytes.
        times: receives variant, k, seconds: descriptors of all observed frames, where the variant
            reads them, and the selection.
    """
    problem = Problem.load(folder, split)
    targets = Split.load(split).targets
    variants = {run.method.name: run for run in learned_runs(weights)}
    compared = {"less_is_more": variants["less_is_more"], "uniform": Run(METHODS["uniform"], 0)}
    sizes, rows = steps(len(problem.candidates), budgets), []
    chosen = {
        name: list(picks_at(problem, run, list(sizes.values()), chance(0)))
        for name, run in compared.items()
    }
    for number, step in enumerate(sizes):
        for name, picks in chosen.items():
            k, frames, _ = picks[number]
            cost = measure_alone(folder, frames, targets, reconstruction)
            rows.append({"method": name, "step": step, "k": k, **cost})
            logger.info("%s", rows[-1])
    cost = measure_alone(folder, problem.candidates, targets, reconstruction)
    every = {"step": EVERY, "k": len(problem.candidates), **cost}
    rows += [{"method": name, **every} for name in compared]
    write_table(pd.DataFrame(rows), costs, units=UNITS, config=config)
    seconds = selection_seconds(problem, variants, budgets, appearance)
    write_table(seconds, times, units={"seconds": "s"}, config=config)


def steps(candidates: int, budgets: Sequence[int]) -> dict[str, int]:
    """Name -> frames: the budgets, and greater shares of the candidates."""
    sizes = {str(k): k for k in budgets}
    for share in SHARES:
        k = round(share * candidates)
        if k > max(budgets):
            sizes[f"{share:.0%}"] = k
    return sizes


def selection_seconds(
    problem: Problem, variants: Mapping[str, Run], budgets: Sequence[int], appearance: Mapping
) -> pd.DataFrame:
    """Table of variant, k, seconds of one thread; see `measure_costs`."""
    images = np.asarray(problem.capture.images[problem.observed])
    a_pool = {
        "appearance": timed(lambda: descriptors(images, appearance["kind"], appearance["weights"])),
        "sharpness": timed(lambda: sharpness(images)),
    }
    rows = []
    for name, run in variants.items():
        before = sum(a_pool[read] for read in run.method.reads)
        for k in budgets:
            select_once(problem, run, k)  # compiles
            rows.append((name, k, before + timed(partial(select_once, problem, run, k))))
    return pd.DataFrame(rows, columns=["variant", "k", "seconds"])


def mean_costs(costs: Files) -> pd.DataFrame:
    """Table of method, step, k, psnr, seconds (fit and rendering), peak_mb, n: means over scenes.

    Args:
        costs: what `measure_costs` wrote, one a scene.
    """
    table = pd.concat([read_table(path) for path in costs])
    table["seconds"] = table["fit_seconds"] + table["render_seconds"]
    table["peak_mb"] = table["peak_bytes"] / 1e6
    groups = table.groupby(["method", "step"], sort=False)
    columns = ["k", "psnr", "seconds", "peak_mb"]
    return groups[columns].mean().assign(n=groups.size()).reset_index()


def saturation(costs: Files, figures: Files, numbers: File, *, facts: Mapping) -> None:
    """PSNR, time and memory against K up to all frames.

    Args:
        costs: what `measure_costs` wrote, one a scene.
        numbers: receives what `mean_costs` returns.
    """
    means = mean_costs(costs)
    write_csv(means, numbers)
    text = f"scenes: {len(costs)}, first draw; last point: every candidate. {note(facts)}"
    curves.saturation(means, DRAWN, figures, text)


VARIANTS = ("less_is_more", "less_is_more_no_appearance", "less_is_more_geometry")


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

TABLE = Table(
    saturation,
    outputs={
        "figures": inputs.figure_files("{reconstructor}saturation"),
        "numbers": "<figures>/{reconstructor}saturation.csv",
    },
    inputs=lambda experiment: {
        "costs": inputs.of_scenes(
            inputs.held_out_scenes(experiment), "{reconstructor}costs.parquet"
        )
    },
    params=lambda experiment: {"facts": specs.facts_of_trained(experiment)},
    category="Paper",
    title="Quality, time, memory against K",
    caption="PSNR, seconds and measured peak memory of reconstruction against the number of "
    "frames, up to all.",
    jobs=[MEASURED],
    needs=[inputs.with_labels],
)
