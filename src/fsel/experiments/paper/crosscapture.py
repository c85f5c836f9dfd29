"""Targets from one pass of a room, frames from its other passes (paper, Table 1)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from fsel.baselines import METHODS
from fsel.data.capture import Capture
from fsel.data.geometry import pose_distance
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import PICK_UNITS, Chance, Run, measure, measured_units, runs, select
from fsel.experiments import specs
from fsel.metrics import Metrics, headings
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, leaders, summarise
from fsel.report.sweep import LEARNED, of_scenes
from fsel.utils.files import read_table, write_table, write_text
from fsel.utils.seeds import name_seed
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

BASELINES = ("random", "uniform", "fvs", "nerf_director", "dpp", "kmedoids", "cover")
SHOWN = {**{name: METHODS[name].label for name in BASELINES}, **LEARNED}


class Trial(NamedTuple):
    """One measurement: what is asked for, and from which frames."""

    held_out: str
    draw: int
    split: Split


def cross_split(
    capture: Capture,
    held_out: str,
    *,
    others: Sequence[str] = (),
    targets: int | None = None,
    rng: np.random.Generator | None = None,
) -> Split:
    """Targets from a held-out pass, proxies and candidates from the others.

    Targets come from the half of the held-out pass that is nearest to a frame of the others; its
    other half is not used. Each target takes one distinct proxy, minimising the summed distance.

    Args:
        capture: of several passes.
        held_out: the pass, one of `capture.sequences`.
        others: further passes of which no frame may be selected.
        targets: how many are drawn from that half; None for all of it.
        rng: which draws them.

    Raises:
        ValueError: when the other passes have fewer frames than there are targets, or the half
            fewer than are drawn.
    """
    of = np.array(capture.sequences)
    away = np.flatnonzero(of == held_out)
    rest = np.flatnonzero(~np.isin(of, [held_out, *others]))
    half = max(1, len(away) // 2)
    count = half if targets is None else targets
    if len(rest) <= count or half < count:
        raise ValueError(
            f"{capture.source}: {len(rest)} frames outside {held_out!r} and {half} in the half of "
            f"it that targets come from, for {count} targets. Hint: a cross-capture scene needs "
            "two or more passes"
        )
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[away], axes[away], centers[rest], axes[rest])
    near = np.argsort(cost.min(axis=1), kind="stable")[:half]
    chosen = np.sort(near if rng is None else rng.choice(near, count, replace=False))
    _, match = linear_sum_assignment(cost[chosen])
    candidates = np.setdiff1d(rest, rest[match])
    return Split(away[chosen], rest[match], candidates, candidates)


def thinned(sequences: Sequence[str], every: int) -> np.ndarray:
    """(n,) int64 every n-th frame of each pass, its first included, in capture order."""
    of = np.array(sequences)
    return np.sort(np.concatenate([np.flatnonzero(of == s)[::every] for s in dict.fromkeys(of)]))


def trials(
    capture: Capture, held_out: Sequence[str], targets: int | None, draws: int, seed: int
) -> Iterator[Trial]:
    """Yield the trials of a room: every held-out pass, and every draw of targets where drawn.

    Args:
        capture: of several passes.
        held_out: passes held out in turn, of none of which frames may be selected; without any,
            each pass in turn, the others being selected from.
        targets: drawn of each; None for all of the nearer half, in one draw.
        draws: of targets.
        seed: of the scene.

    Raises:
        ValueError: for a pass that is not there, and as `cross_split`.
    """
    present = list(dict.fromkeys(capture.sequences))
    if unknown := [name for name in held_out if name not in present]:
        raise ValueError(
            f"{capture.source}: crosscapture.held_out has {unknown}; its passes are {present}"
        )
    for name in held_out or present:
        for draw in range(1 if targets is None else draws):
            rng = None
            if targets is not None:
                rng = np.random.default_rng([seed, 3, name_seed(name), draw])
            split = cross_split(capture, name, others=held_out, targets=targets, rng=rng)
            yield Trial(name, draw, split)


def select_crosscapture(
    folder: str | Path,
    weights: Sequence[str | Path],
    picks: str | Path,
    *,
    held_out: Sequence[str],
    every: int,
    targets: int | None,
    draws: int,
    budgets: Sequence[int],
    seed: int,
    config: str,
) -> None:
    """Every method's picks with passes of a room held out in turn.

    Args:
        folder: a canonical capture of several passes, with its descriptors.
        weights: scorers of the learned methods.
        picks: receives held_out, draw and the columns of `fsel.evaluation.measuring.select`.
        held_out, targets, draws: see `trials`.
        every: keep every n-th frame of each pass.
        budgets: frames to pick.
        seed: of the scene.
        config: digest of the parameters.
    """
    whole = Capture.load(folder)
    kept = thinned(whole.sequences, every)
    described = read_table(Path(folder) / "descriptors.parquet").iloc[kept]
    capture = whole.subset(kept)
    contenders = runs([METHODS[name] for name in BASELINES], weights)
    tables = []
    for trial in trials(capture, held_out, targets, draws, seed):
        problem = Problem.of(capture, trial.split, described)
        chosen = select(problem, contenders, budgets, _chance(seed, trial))
        chosen["frame"] = kept[chosen["frame"]]
        tables.append(chosen.assign(held_out=trial.held_out, draw=trial.draw))
        logger.info("%s: %d targets held out", trial.held_out, len(problem.targets))
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def _chance(seed: int, trial: Trial) -> Chance:
    def of(run: Run, k: int) -> np.random.Generator:
        return np.random.default_rng([seed, run.seed, name_seed(trial.held_out), k, trial.draw])

    return of


def evaluate_crosscapture(
    folder: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    held_out: Sequence[str],
    every: int,
    targets: int | None,
    draws: int,
    seed: int,
    reconstruction: Mapping,
    metrics: Metrics,
    config: str,
) -> None:
    """Measure what the picks are worth on the targets of the pass that was held out.

    Args:
        folder: a canonical capture of several passes.
        picks: what `select_crosscapture` wrote.
        evaluation: receives held_out, draw and the columns of `fsel.evaluation.measuring.measure`.
        held_out, every, targets, draws, seed: as in `select_crosscapture`.
        reconstruction: the config's section.
        metrics: names, or name -> settings.
        config: digest of the parameters.
    """
    whole = Capture.load(folder)
    kept = thinned(whole.sequences, every)
    capture = whole.subset(kept)
    reconstructor = reconstructor_of(capture, reconstruction)
    picked, tables = read_table(picks), []
    for trial in trials(capture, held_out, targets, draws, seed):
        part = picked[(picked["held_out"] == trial.held_out) & (picked["draw"] == trial.draw)]
        evaluator = Evaluator.on_frames(reconstructor, trial.split.targets, metrics=metrics)
        table = measure(evaluator, part.assign(frame=np.searchsorted(kept, part["frame"])))
        table["target"] = kept[table["target"]]
        tables.append(table.assign(held_out=trial.held_out, draw=trial.draw))
        logger.info("%s: %.2f dB", trial.held_out, table["psnr"].mean())
    write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)


def crosscapture(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """The table "Cross-capture novel view synthesis"; one measurement a room and held-out pass.

    Passes of one room are one place to the intervals: their means are averaged first.

    Args:
        evaluations: what `evaluate_crosscapture` wrote, one a room.
        table, numbers: receive LaTeX, and method, k, metric, mean, ci_low, ci_high, leads, n.
        scenes: dataset and scene of every room.
        budgets: columns.
        metrics: of a cell, in order; names, or name -> settings.
        facts: see `captions.made_by`.
    """
    places = facts.get("places", {})
    measured = of_scenes(scenes, evaluations)
    cells = pd.concat([part for item in measured for part in _measurements(item, metrics, places)])
    means = summarise(cells, metrics).drop(columns="dataset")
    ahead = leaders(differences(cells, list(SHOWN), metrics))
    keys = zip(means["method"], means["k"], means["metric"], strict=True)
    means["leads"] = [key in ahead for key in keys]
    write_csv(means, numbers)
    text = (
        r"\textbf{Cross-capture novel view synthesis.} Targets come from the half of one held-out "
        "pass of a room that is nearest to its other passes; candidates and proxies come from "
        f"those. {cells['scene'].nunique()} pairs of room and held-out pass, averaged within each "
        f"of {means['n'].max()} rooms, then over rooms. Bold: ahead of every other row, each "
        f"paired 95\\% interval over rooms excluding zero. {made_by(facts)}"
    )
    head = ["Method", *headings(metrics) * len(budgets)]
    values = means.set_index(["method", "k", "metric"])
    rows = [
        [label, *(_cell(values, name, k, metric) for k in budgets for metric in metrics)]
        for name, label in SHOWN.items()
    ]
    groups = [(f"$K{{=}}{k}$", len(metrics)) for k in budgets]
    made = plain_table(head, rows, caption=text, label="tab:crossvideowopt", groups=groups)
    write_text(made, table)


def _measurements(
    item: Mapping, metrics: Metrics, places: Mapping[str, str]
) -> Iterator[pd.DataFrame]:
    """Table of dataset, scene (room and pass), place (room), draw, method, k, metrics."""
    room = f"{item['dataset']}/{item['scene']}"
    for (held_out, draw), part in read_table(item["path"]).groupby(["held_out", "draw"]):
        # one set of measurements whatever the dataset, so that each room counts once
        where = {
            "dataset": "crosscapture",
            "scene": f"{room}/{held_out}",
            "place": places.get(room, room),
        }
        yield draw_means(part, metrics).assign(**where, draw=draw)


def _cell(values: pd.DataFrame, method: str, k: int, metric: str) -> str:
    row = values.loc[(method, k, metric)]
    text = number(row["mean"], metric)
    return rf"\textbf{{{text}}}" if row["leads"] else text


def budgets_of(experiment: Experiment) -> list[int]:
    """The budgets near 30 and 40, the table's columns."""
    return sorted({experiment.budget_near(30), experiment.budget_near(40)})


def _trials(experiment: Experiment) -> dict[str, Any]:
    config = experiment.config
    return {
        **{key: config["crosscapture"][key] for key in ("every", "targets")},
        "draws": config["draws"],
        "held_out": lambda wildcards: inputs.passes(experiment, wildcards),
        "seed": specs.scene_seed(experiment, "crosscapture"),
    }


PICKED = Job(
    select_crosscapture,
    outputs={"picks": f"{inputs.SCENE}/crosscapture_picks.parquet"},
    message="Selecting with each pass of {wildcards.dataset}/{wildcards.scene} held out",
    inputs=specs.selected,
    params=lambda experiment: {**_trials(experiment), "budgets": budgets_of(experiment)},
    size=Size(4000, 60, "capture"),
)

EVALUATED = Job(
    evaluate_crosscapture,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}crosscapture.parquet"},
    message="Reconstructing {wildcards.dataset}/{wildcards.scene} with each pass held out",
    inputs=lambda experiment: specs.picks_of("crosscapture_picks.parquet"),
    params=lambda experiment: {**_trials(experiment), **specs.measured(experiment)},
    size=Size(4000, 60, "reconstruction"),
)

TABLE = Table(
    crosscapture,
    outputs=inputs.table_files("{reconstructor}crosscapture"),
    message="Writing the cross-capture table",
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            inputs.rooms(experiment), "{reconstructor}crosscapture.parquet"
        )
    },
    params=lambda experiment: {
        "scenes": inputs.rooms(experiment),
        "budgets": budgets_of(experiment),
        "metrics": experiment.metrics,
        "facts": specs.facts_about(experiment, specs.datasets_of(inputs.rooms(experiment))),
    },
    category="Paper",
    title="Cross-capture",
    caption="Every method where the targets come from a held-out pass of a room and the frames "
    "from its others.",
    jobs=[PICKED, EVALUATED],
)
