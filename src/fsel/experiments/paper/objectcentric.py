"""Views of one object in a capture, scored inside its masks (paper, section 4.2)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fsel.baselines import METHODS
from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split, evaluation_split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import PICK_UNITS, draw_chance, measure, measured_units, runs, select
from fsel.experiments import specs
from fsel.experiments.paper.crosscapture import BASELINES
from fsel.metrics import Metrics, headings, inside
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import number, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, leaders, summarise
from fsel.report.sweep import LEARNED, of_scenes
from fsel.request.focus import from_capture
from fsel.utils.files import read_table, write_table, write_text
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

UNTRAINED = (*BASELINES, "nearest")
TRAINED = ("less_is_more", "fsel")
SHOWN = {
    **{name: METHODS[name].label for name in UNTRAINED},
    **{name: LEARNED[name] for name in TRAINED},
}
LEAST = 0.02  # share of the image that the object fills in a view that is asked for


def object_split(capture: Capture, draw: int, seed: int, targets: int) -> Split:
    """Targets drawn among the frames that show the object; the rest as in `evaluation_split`.

    Args:
        capture: at the size that is scored, with masks.
        draw: number of the draw.
        seed: of the scene.
        targets: how many.

    Raises:
        ValueError: for a capture without masks, or when too few frames show the object.
    """
    if capture.masks is None:
        raise ValueError(
            f"{capture.source}: no masks, which say where the object is. Hint: of ScanNet, "
            "`reading.instance` chooses the object that they show"
        )
    showing = np.flatnonzero(inside(np.asarray(capture.masks)) >= LEAST)
    if len(showing) < targets:
        raise ValueError(
            f"{capture.source}: {len(showing)} frames show the object on {LEAST:.0%} of the image "
            f"or more, {targets} are needed as targets. Hint: choose a larger object, or lower "
            "`targets`"
        )
    return evaluation_split(capture, draw, seed, targets, showing)


def object_problem(capture: Capture, split: Split, described: pd.DataFrame) -> Problem:
    """The selection problem of a split, the object's centre being every view's reference point.

    The centre is found from the masks of frames that may be used, never from the targets'.
    """
    problem = Problem.of(capture, split, described)
    return replace(problem, focus=from_capture(capture, problem.observed).center)


def select_objects(
    folder: str | Path,
    weights: Sequence[str | Path],
    picks: str | Path,
    *,
    k: int,
    draws: int,
    targets: int,
    seed: int,
    long_side: int,
    config: str,
) -> None:
    """Every method's picks for views of one object.

    Args:
        folder: a canonical capture with masks and descriptors.
        weights: scorers of the learned methods.
        picks: receives draw and the columns of `fsel.evaluation.measuring.select`.
        k: frames to pick.
        draws: of targets.
        targets: of a draw.
        seed: of the scene.
        long_side: pixels of the images that are compared, at which masks are counted.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    small = capture.resized(long_side)
    contenders = runs([METHODS[name] for name in UNTRAINED], weights)
    tables = []
    for draw in range(draws):
        split = object_split(small, draw, seed, targets)
        problem = object_problem(capture, split, described)
        tables.append(select(problem, contenders, [k], draw_chance(seed, draw)).assign(draw=draw))
        logger.info("draw %d: the object's centre is %s", draw, problem.focus)
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def evaluate_objects(
    folder: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    targets: int,
    seed: int,
    reconstruction: Mapping,
    metrics: Metrics,
    config: str,
) -> None:
    """Measure what the picks are worth inside the object's masks.

    Args:
        folder: a canonical capture with masks.
        picks: what `select_objects` wrote.
        evaluation: receives draw and the columns of `fsel.evaluation.measuring.measure`.
        targets, seed: as in `select_objects`.
        reconstruction: the config's section.
        metrics: names, or name -> settings.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    tables = []
    for draw, part in read_table(picks).groupby("draw"):
        frames = object_split(reconstructor.capture, draw, seed, targets).targets
        evaluator = Evaluator.on_frames(reconstructor, frames, masked=True, metrics=metrics)
        tables.append(measure(evaluator, part).assign(draw=draw))
        logger.info("draw %d: %.2f dB", draw, tables[-1]["psnr"].mean())
    write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)


def objectcentric(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    datasets: Mapping[str, str],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """The table "Object-centric novel view synthesis".

    Args:
        evaluations: what `evaluate_objects` wrote, one a scene.
        table, numbers: receive LaTeX, and dataset, method, k, metric, mean, ci_low, ci_high, n,
            leads.
        scenes: dataset and scene of each.
        datasets: name -> printed label, in order.
        metrics: of a cell, in order; names, or name -> settings.
        facts: see `captions.made_by`.
    """
    cells = pd.concat([_measurements(item, metrics) for item in of_scenes(scenes, evaluations)])
    place = {name: at for at, name in enumerate(SHOWN)}
    cells = cells.sort_values("method", key=lambda names: names.map(place), kind="stable")
    means = summarise(cells, metrics)
    gaps = differences(cells, list(SHOWN), metrics)
    ahead = {(name, *key) for name, part in gaps.groupby("dataset") for key in leaders(part)}
    keys = zip(*(means[key] for key in ("dataset", "method", "k", "metric")), strict=True)
    means["leads"] = [key in ahead for key in keys]
    write_csv(means, numbers)
    values = means.set_index(["dataset", "method", "metric"])
    rows = [
        [label, *(_cell(values.loc[dataset, name, m], m) for dataset in datasets for m in metrics)]
        for name, label in SHOWN.items()
    ]
    count = means.groupby("dataset")["n"].first()
    titles = [rf"\textbf{{{tex(label)}}} ($n{{=}}{count[d]}$)" for d, label in datasets.items()]
    made = plain_table(
        ["Selection", *headings(metrics) * len(datasets)],
        rows,
        caption=_caption(int(means["k"].iloc[0]), facts),
        label="tab:objectcentric",
        groups=[(title, len(metrics)) for title in titles],
    )
    write_text(made, table)


def _caption(k: int, facts: Mapping) -> str:
    return (
        rf"\textbf{{Object-centric novel view synthesis}}, $K{{=}}{k}$. Targets are views that "
        "show one object, and all metrics are taken inside its mask alone; the object's centre is "
        "the reference point of every view. Means over targets, target draws and seeds "
        r"within a scene, then over scenes. Bold: ahead of every other row, each paired 95\% "
        f"interval over them excluding zero. {made_by(facts)}"
    )


def _measurements(item: Mapping, metrics: Metrics) -> pd.DataFrame:
    """Table of every draw of a scene: dataset, scene, draw, method, k, metrics."""
    parts = [
        draw_means(part, metrics).assign(draw=draw)
        for draw, part in read_table(item["path"]).groupby("draw")
    ]
    return pd.concat(parts).assign(dataset=item["dataset"], scene=item["scene"])


def _cell(row: pd.Series, metric: str) -> str:
    text = number(row["mean"], metric)
    return rf"\textbf{{{text}}}" if row["leads"] else text


def _trials(experiment: Experiment) -> dict[str, Any]:
    return {
        "targets": experiment.config["targets"],
        "seed": specs.scene_seed(experiment, "objects"),
    }


def _table_settings(experiment: Experiment) -> dict[str, Any]:
    scenes = inputs.object_scenes(experiment)
    names = specs.datasets_of(scenes)
    return {
        "scenes": scenes,
        "datasets": experiment.labels(names),
        "metrics": experiment.metrics,
        "facts": specs.facts_about(experiment, names),
    }


PICKED = Job(
    select_objects,
    outputs={"picks": f"{inputs.SCENE}/objects_picks.parquet"},
    message="Selecting views of the object of {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: {
        **inputs.capture([*inputs.DESCRIBED, "masks"]),
        "weights": [*experiment.weights("less_is_more"), *experiment.fsel],
    },
    params=lambda experiment: {
        **_trials(experiment),
        "k": experiment.budget_near(30),
        "draws": experiment.config["draws"],
        "long_side": experiment.reconstruction["long_side"],
    },
    size=Size(4000, 60, "capture"),
)

EVALUATED = Job(
    evaluate_objects,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}objects.parquet"},
    message="Reconstructing the object of {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: specs.picks_of("objects_picks.parquet", [*inputs.CAPTURE, "masks"]),
    params=lambda experiment: {**_trials(experiment), **specs.measured(experiment)},
    size=Size(4000, 60, "reconstruction"),
)

TABLE = Table(
    objectcentric,
    outputs=inputs.table_files("{reconstructor}objectcentric"),
    message="Writing the object-centric table",
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            inputs.object_scenes(experiment), "{reconstructor}objects.parquet"
        )
    },
    params=_table_settings,
    category="Paper",
    title="Object-centric",
    caption="Every method where one object is to be seen: targets show it, metrics are taken "
    "inside its masks.",
    jobs=[PICKED, EVALUATED],
)
