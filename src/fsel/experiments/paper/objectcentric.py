"""Views of one object in a capture, scored inside its masks (paper, section 4.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.problem import Problem
from fsel.core.split import Split, evaluation_split
from fsel.evaluation.latex import made_by, plain_table, tex
from fsel.evaluation.measuring import rng_by_draw
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import LABELS
from fsel.experiments.paper.crosscapture import BASELINES
from fsel.experiments.scheme import ExperimentCase, Scenes, Trials, cells_of, led_rows, with_leads
from fsel.metrics import Metrics, headings
from fsel.metrics.fused import inside
from fsel.selection.focus import from_capture

UNTRAINED = (*BASELINES, "nearest")
TRAINED = ("less_is_more", "fsel")
SHOWN = {name: LABELS[name] for name in (*UNTRAINED, *TRAINED)}
LEAST = 0.02  # share of the image that the object fills in a target view


def object_split(capture: Capture, draw: int, seed: int, targets: int) -> Split:
    """Draw targets among the frames that show the object, in masks at the scored size; the rest as
    in `evaluation_split`. ValueError without masks, or for too few such frames."""
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


def around_object(capture: Capture, split: Split, described: pd.DataFrame) -> Problem:
    """Return the problem with the object's centre as every view's reference point, found from the
    masks of frames that may be used, never from the targets'."""
    problem = Problem.of(capture, split, described)
    return replace(problem, focus=from_capture(problem.capture, problem.observed).center)


def trials(
    capture: Capture, *, k: int, draws: int, targets: int, seed: int, long_side: int
) -> Iterator[ExperimentCase]:
    """Yield a trial for each draw of targets; masks are counted at `long_side` pixels."""
    small = capture.resized(long_side)
    for draw in range(draws):
        split, rng_of = object_split(small, draw, seed, targets), rng_by_draw(seed, draw)
        yield ExperimentCase({"draw": draw}, capture, split, [k], rng_of, problem=around_object)


def objectcentric(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    datasets: Mapping[str, str],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """Write the table "Object-centric novel view synthesis", with columns for each dataset."""
    cells = cells_of(scenes, evaluations, metrics, facts)
    place = {name: at for at, name in enumerate(SHOWN)}
    cells = cells.sort_values("method", key=lambda names: names.map(place), kind="stable")
    means = with_leads(cells, list(SHOWN), metrics)
    write_csv(means, numbers)
    k, count = int(means["k"].iloc[0]), means.groupby("dataset")["n"].first()
    text = (
        rf"\textbf{{Object-centric novel view synthesis}}, $K{{=}}{k}$. Targets are views that "
        "show one object, and all metrics are taken inside its mask alone; the object's centre is "
        "the reference point of every view. Means over targets, target draws and seeds "
        r"within a scene, then over scenes. Bold: ahead of every other row, each paired 95\% "
        f"interval over them excluding zero. {made_by(facts)}"
    )
    titles = [rf"\textbf{{{tex(label)}}} ($n{{=}}{count[d]}$)" for d, label in datasets.items()]
    made = plain_table(
        ["Selection", *headings(metrics) * len(datasets)],
        led_rows(means, SHOWN, [(dataset, k) for dataset in datasets], metrics),
        caption=text,
        label="tab:objectcentric",
        groups=[(title, len(metrics)) for title in titles],
    )
    write_text(made, table)


TRIALS = Trials(trials, methods=UNTRAINED, masked=True)
