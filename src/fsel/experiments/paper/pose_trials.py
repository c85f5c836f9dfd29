"""Selectors on poses that are not exact: estimated from the images, or disturbed on purpose."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fsel.baselines import FURTHER, PAPER
from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import evaluation_split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import PICK_UNITS, draw_chance, measure, measured_units, runs, select
from fsel.experiments import specs
from fsel.experiments.paper.pose_errors import perturbed
from fsel.metrics import METRICS, Metrics
from fsel.reconstruct import reconstructor_of
from fsel.utils.files import read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)

SELECTORS = {**PAPER, **FURTHER}
EXACT, ESTIMATED = "none", "estimated"  # what was done to the poses
SELECTOR, BOTH = "selector", "both"  # who works with the poses that result
NOISE = ["change", "level", "noise"]
Budgets = Callable[[Experiment], Sequence[int]]
Chosen = Callable[[Experiment], Metrics]


def select_estimated(
    given_folder: str | Path,
    estimated_folder: str | Path,
    weights: Sequence[str | Path],
    picks: str | Path,
    *,
    draws: int,
    budgets: Sequence[int],
    targets: int,
    seed: int,
    split_seed: int,
    config: str,
) -> None:
    """Every selector on given and on estimated poses.

    Args:
        given_folder, estimated_folder: what `estimate_poses` wrote; descriptors beside the first.
        weights: scorers of the learned methods.
        picks: receives draw, change (`none` or `estimated`) and the columns of
            `fsel.evaluation.measuring.select`.
        draws: of targets.
        budgets: frames to pick.
        targets: held-out views of a draw.
        seed: of the scene.
        split_seed: of the scene's draws of targets.
        config: digest of the parameters.
    """
    captures = {EXACT: Capture.load(given_folder), ESTIMATED: Capture.load(estimated_folder)}
    described = read_table(Path(given_folder) / "descriptors.parquet")
    contenders = runs(SELECTORS.values(), weights)
    tables = []
    for draw in range(draws):
        for change, seen in captures.items():
            problem = _problem(seen, draw, described, targets, split_seed)
            chosen = select(problem, contenders, budgets, draw_chance(seed, draw))
            tables.append(chosen.assign(draw=draw, change=change))
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def evaluate_estimated(
    given_folder: str | Path,
    estimated_folder: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    targets: int,
    split_seed: int,
    reconstruction: Mapping,
    metrics: Metrics = METRICS,
    config: str,
) -> None:
    """Measure what the picks are worth: with the poses that selectors saw, and with the given ones.

    Args:
        given_folder, estimated_folder: as in `select_estimated`.
        picks: what it wrote.
        evaluation: receives draw, change, scope (who works with the poses: `selector` alone, the
            reconstruction having the given ones, or `both`) and the columns of
            `fsel.evaluation.measuring.measure`.
        targets, split_seed: as in `select_estimated`.
        reconstruction: the config's section.
        metrics: names, or name -> settings.
        config: digest of the parameters.
    """
    captures = {EXACT: Capture.load(given_folder), ESTIMATED: Capture.load(estimated_folder)}
    built = {name: reconstructor_of(c, reconstruction) for name, c in captures.items()}
    tables = []
    for draw, part in read_table(picks).groupby("draw"):
        frames = _drawn(captures[EXACT], draw, targets, split_seed)
        evaluators = {
            name: Evaluator.on_frames(r, frames, metrics=metrics) for name, r in built.items()
        }
        for change, picked in part.groupby("change", sort=False):
            table = _measure(picked, evaluators[EXACT], evaluators[change], change)
            tables.append(table.assign(draw=draw, change=change))
    write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)


def select_noise(
    folder: str | Path,
    weights: Sequence[str | Path],
    picks: str | Path,
    *,
    levels: Mapping[str, Sequence[float]],
    noises: int,
    budgets: Sequence[int],
    targets: int,
    seed: int,
    split_seed: int,
    config: str,
) -> None:
    """Every selector on poses with ever more noise, in rotations and in centres; first draw.

    Sparse points stay where they are.

    Args:
        folder: a canonical capture with its descriptors.
        weights: scorers of the learned methods.
        picks: receives draw, change (`none`, or a key of `levels`), level, noise (its seed) and the
            columns of `fsel.evaluation.measuring.select`.
        levels: `degrees` and `percent` -> levels, see
            `fsel.experiments.paper.pose_errors.perturbed`.
        noises: seeds of the noise.
        budgets, targets, seed, split_seed: as in `select_estimated`.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    contenders = runs(SELECTORS.values(), weights)
    cases = [(EXACT, 0.0, 0)]
    cases += [(c, float(at), n) for c in levels for at in levels[c] for n in range(noises)]
    tables = []
    for case in cases:
        problem = _problem(disturbed(capture, *case, seed), 0, described, targets, split_seed)
        chosen = select(problem, contenders, budgets, draw_chance(seed, 0))
        tables.append(chosen.assign(draw=0, **dict(zip(NOISE, case, strict=True))))
        logger.info("%s %g, noise %d", *case)
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def evaluate_noise(
    folder: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    targets: int,
    seed: int,
    split_seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what the picks are worth: with the poses that selectors saw, and with the exact ones.

    Args:
        folder: a canonical capture.
        picks: what `select_noise` wrote.
        evaluation: receives draw, change, level, noise, scope (as in `evaluate_estimated`) and the
            columns of `fsel.evaluation.measuring.measure`.
        targets, seed, split_seed: as in `select_estimated`.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    frames = _drawn(capture, 0, targets, split_seed)
    exact = Evaluator.on_frames(reconstructor_of(capture, reconstruction), frames)
    tables = []
    for (change, level, noise), picked in read_table(picks).groupby(NOISE, sort=False):
        seen, case = disturbed(capture, change, level, noise, seed), (change, level, noise)
        own = Evaluator.on_frames(reconstructor_of(seen, reconstruction), frames)
        table = _measure(picked, exact, own, change)
        tables.append(table.assign(draw=0, **dict(zip(NOISE, case, strict=True))))
        logger.info("%s %g, noise %d: %.2f dB", *case, table["psnr"].mean())
    write_table(pd.concat(tables), evaluation, units=measured_units(), config=config)


def disturbed(capture: Capture, change: str, level: float, noise: int, seed: int) -> Capture:
    """The capture with noise in its poses; with none where `change` is `none`."""
    if change == EXACT:
        return capture
    amounts = {"degrees": 0.0, "percent": 0.0, change: level}
    rng = np.random.default_rng([seed, noise])
    return replace(capture, world_to_camera=perturbed(capture.world_to_camera, **amounts, rng=rng))


def _problem(
    seen: Capture, draw: int, described: pd.DataFrame, targets: int, split_seed: int
) -> Problem:
    """The problem as a selector sees it: proxies too are matched by the poses seen."""
    return Problem.of(seen, evaluation_split(seen, draw, split_seed, targets), described)


def _drawn(capture: Capture, draw: int, targets: int, split_seed: int) -> np.ndarray:
    """The targets of a draw: chance alone decides, whatever the poses."""
    return evaluation_split(capture, draw, split_seed, targets).targets


def _measure(picked: pd.DataFrame, exact: Evaluator, own: Evaluator, change: str) -> pd.DataFrame:
    """Table of scope and what `measure` returns; picks on exact poses are of one scope."""
    evaluators = {BOTH: exact} if change == EXACT else {SELECTOR: exact, BOTH: own}
    return pd.concat([measure(e, picked).assign(scope=scope) for scope, e in evaluators.items()])


def _draws(experiment: Experiment) -> dict[str, Any]:
    return {
        "targets": experiment.config["targets"],
        "split_seed": specs.scene_seed(experiment, "split"),
    }


def budgets_tried(experiment: Experiment) -> list[int]:
    """The budgets up to 30: of a capture of few frames, larger ones would take nearly all."""
    most = experiment.budget_near(30)
    return [k for k in experiment.config["budgets"] if k <= most]


def selecting(name: str, folder: str, picks: str, budgets: Budgets, purpose: str) -> Job:
    """The rule that selects on two captures of the same frames.

    Args:
        name: of the rule.
        folder: of both captures, within the scene's.
        picks: the file to write there.
        budgets: experiment -> frames to pick.
        purpose: of the seed.
    """
    return Job(
        select_estimated,
        name=name,
        outputs={"picks": f"{inputs.SCENE}/{folder}/{picks}.parquet"},
        message="Selecting on two sources of poses of {wildcards.dataset}/{wildcards.scene}",
        inputs=lambda experiment: {
            **specs.two_captures(folder, described=True),
            "weights": experiment.scorers,
        },
        params=lambda experiment: {
            **_draws(experiment),
            "draws": experiment.config["draws"],
            "budgets": budgets(experiment),
            "seed": specs.scene_seed(experiment, purpose),
        },
        size=Size(4000, 60, "capture"),
    )


def evaluating(name: str, folder: str, picks: str, evaluation: str, metrics: Chosen) -> Job:
    """The rule that measures what `selecting` picked.

    Args:
        name: of the rule.
        folder: of both captures, within the scene's.
        picks: the file that `selecting` wrote there.
        evaluation: the file to write there.
        metrics: experiment -> metrics.
    """
    return Job(
        evaluate_estimated,
        name=name,
        outputs={"evaluation": f"{inputs.SCENE}/{folder}/{{reconstructor}}{evaluation}.parquet"},
        message="Reconstructing {wildcards.dataset}/{wildcards.scene} with two sources of poses",
        inputs=lambda experiment: {
            **specs.two_captures(folder),
            "picks": f"{inputs.SCENE}/{folder}/{picks}.parquet",
        },
        params=lambda experiment: {
            **_draws(experiment),
            "reconstruction": experiment.reconstruction_of,
            "metrics": metrics(experiment),
        },
        size=Size(4000, 60, "reconstruction"),
    )


NOISY_PICKED = Job(
    select_noise,
    outputs={"picks": f"{inputs.SCENE}/poses/noise_picks.parquet"},
    message="Selecting on poses of {wildcards.dataset}/{wildcards.scene} with noise",
    inputs=specs.selected,
    params=lambda experiment: {
        **_draws(experiment),
        "levels": {k: experiment.config["inexact_poses"][k] for k in ("degrees", "percent")},
        "noises": experiment.config["inexact_poses"]["noises"],
        "budgets": [experiment.budget_near(30)],
        "seed": specs.scene_seed(experiment, "poses"),
    },
    size=Size(4000, 60, "capture"),
)

NOISY_EVALUATED = Job(
    evaluate_noise,
    outputs={"evaluation": f"{inputs.SCENE}/poses/{{reconstructor}}noise.parquet"},
    message="Reconstructing {wildcards.dataset}/{wildcards.scene} with noise in its poses",
    inputs=lambda experiment: specs.picks_of("poses/noise_picks.parquet"),
    params=lambda experiment: {
        **_draws(experiment),
        "seed": specs.scene_seed(experiment, "poses"),
        "reconstruction": experiment.reconstruction_of,
    },
    size=Size(4000, 60, "reconstruction"),
)
