"""Fit what `fsel.selection.budget` predicts, to reconstructions of training scenes."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_text
from fsel.core.split import coverage_split
from fsel.evaluation.measuring import chance
from fsel.experiments import scheme, specs
from fsel.experiments.specs import Scenes, Values
from fsel.selection.budget import shifts, view_shift
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)

COUNTS = (4, 6, 8, 10, 13, 16, 20, 25, 30, 40, 50, 60)  # frames reconstructed from
REPEATS = 3  # requests of each coverage
SHIFTS = ["first", "second", "third"]
REQUEST = ["coverage", "repeat"]
CURVE = ["dataset", "scene", *REQUEST]


def trials(capture: Capture, *, coverages: Sequence[int], seed: int) -> Iterator[scheme.Trial]:
    """Yield requests of several sizes on one scene, at every number of frames that it has.

    Args:
        coverages: per cent of the capture that requests are drawn from.
    """
    for coverage, repeat in product(coverages, range(REPEATS)):
        split = coverage_split(capture, coverage, seed + repeat)
        most = len(split.candidates) + len(split.proxies)
        budgets = [k for k in COUNTS if k <= most]
        key = {"coverage": coverage, "repeat": repeat}
        yield scheme.Trial(key, capture, split, budgets, chance(seed))


def curves(capture: Capture, picks: pd.DataFrame, evaluation: pd.DataFrame) -> pd.DataFrame:
    """PSNR of every request of a scene against the mean shifts of its first picks.

    Args:
        capture: the scene's.
        picks, evaluation: what the jobs of `TRIALS` wrote of it.

    Returns:
        coverage, repeat, k, psnr, and the mean shifts of `fsel.selection.budget.shifts`.
    """
    tables = []
    for request, part in evaluation.groupby(REQUEST, sort=False):
        own = picks[(picks[REQUEST] == list(request)).all(axis=1)]
        frames = own["frame"][own["k"] == own["k"].max()].to_numpy(np.int64)
        psnr = part.groupby("k")["psnr"].mean()
        means = shifts(view_shift(capture, frames, capture.view(part["target"].unique())))
        table = pd.DataFrame(means, columns=SHIFTS).loc[psnr.index].assign(psnr=psnr)
        tables.append(table.reset_index().assign(**dict(zip(REQUEST, request, strict=True))))
    return pd.concat(tables)


def fit_worth(curves: pd.DataFrame) -> np.ndarray:
    """(3,) dB that a field of view is worth, by non-negative least squares.

    Every curve has an offset of its own: what a scene reaches at best is not predicted. All
    datasets weigh the same.

    Args:
        curves: dataset, scene, and the columns of `curves`.
    """
    from scipy.optimize import nnls  # here: every job imports this module

    columns = [*SHIFTS, "psnr"]
    offset = curves.groupby(CURVE)[columns].transform("mean")
    weight = np.sqrt(1 / curves.groupby("dataset")["psnr"].transform("size").to_numpy())
    centred = (curves[columns] - offset).to_numpy() * weight[:, None]
    return nnls(-centred[:, :-1], centred[:, -1])[0]


def fit_budget(
    folders: Files, picks: Files, evaluations: Files, record: File, *, scenes: Scenes, config: str
) -> None:
    """Fit the prediction to all training scenes.

    Args:
        picks, evaluations: what the jobs of `TRIALS` wrote, one a scene.
        record: receives `worth` and where it comes from, as JSON.
    """
    tables = []
    for (dataset, scene), folder, *paths in zip(scenes, folders, picks, evaluations, strict=True):
        table = curves(Capture.load(folder), *map(read_table, paths))
        tables.append(table.assign(dataset=dataset, scene=scene))
    every = pd.concat(tables)
    worth = fit_worth(every)
    count = len(every.drop_duplicates(CURVE))
    made = f"least squares on {count} curves of PSNR against K of {len(scenes)} scenes"
    content = {
        "worth": worth.round(4).tolist(),
        "unit": "dB a field of view, of the closest, second and third frame",
        "provenance": {"made by": made, "config": config},
        "remade by": "make weights",
    }
    write_text(json.dumps(content, indent=2) + "\n", record)
    logger.info("%s: %s", made, worth)


TRIALS = scheme.Trials(
    f"{__name__}:TRIALS",
    "curves",
    trials,
    settings=lambda experiment: {
        "coverages": experiment.config["coverages"],
        "seed": specs.scene_seed(experiment, "budget"),
    },
    weights=lambda experiment: experiment.fsel[:1],
    metrics=lambda experiment: ("psnr",),
    minutes=30,
)

RECORD = "<results>/selector/budget.json"


def _fitted(experiment: Experiment) -> Values:
    names = experiment.practised or inputs.with_labels(experiment)
    return {
        **inputs.captures(names),
        "picks": inputs.of_problems(names, "curves_picks.parquet"),
        "evaluations": inputs.of_problems(names, "curves.parquet"),
    }


FITTED = Job(
    fit_budget,
    outputs={"record": RECORD},
    message="Fitting what further frames bring",
    inputs=_fitted,
    params=lambda experiment: {"scenes": [name.split("/") for name in experiment.practised]},
)

JOBS = (*TRIALS.jobs, FITTED)
