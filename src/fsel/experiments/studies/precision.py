"""Worth of arithmetic: float64, float32 and the compiled loop; training in either.

What is compared are loops inside one method, no methods, and they are timed without its features:
picks are made here, and measured by the evaluator that all experiments have.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from fsel.core.capture import Views
from fsel.core.files import File, Files, read_table, write_text
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.captions import made_by
from fsel.evaluation.evaluator import Evaluator, evaluators
from fsel.evaluation.latex import MISSING, plain_table, tex
from fsel.evaluation.measuring import measured
from fsel.evaluation.numbers import write_csv
from fsel.experiments import specs
from fsel.experiments.specs import Values
from fsel.experiments.studies.hard_cases import CASES
from fsel.experiments.studies.hard_cases.case import on_frames
from fsel.experiments.studies.selection_time import timed
from fsel.selectors import plain
from fsel.selectors.greedy import Prepared, greedy
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import Network, Scorer
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Table

if TYPE_CHECKING:
    from fsel.training.labelled import Scenes

logger = logging.getLogger(__name__)

ARITHMETIC = ("float64", "float32", "kernel")
PRECISIONS = ("float64", "float32")  # of training
TRAINED = "less_is_more"  # the policy whose training is compared
FEW = 8  # picks in a hard case
HARD, TRAINING, LOSS = "Hard cases", "Training in float32", "loss"
COLUMNS = ["part", "name", "method", "arithmetic", "agreement", "psnr", "psnr_change"]


def single(problem: Problem) -> Problem:
    """The same problem with poses, intrinsics and sharpness in float32."""

    def views(given: Views) -> Views:
        poses, intrinsics = given.world_to_camera, given.intrinsics
        return Views(poses.astype(np.float32), intrinsics.astype(np.float32), given.size)

    low = views(problem.capture.views)
    capture = replace(
        problem.capture, world_to_camera=low.world_to_camera, intrinsics=low.intrinsics
    )
    sharp = problem.sharpness.astype(np.float32)
    return replace(problem, capture=capture, targets=views(problem.targets), sharpness=sharp)


def selections(
    problem: Problem, policy: str, scorer: Scorer, k: int
) -> dict[str, tuple[np.ndarray, Callable[[], object]]]:
    """Arithmetic -> (k,) frames, and the greedy loop that picks them, features given."""
    exact, low = (POLICIES[policy].prepare(p) for p in (problem, single(problem)))
    loops = {
        "float64": partial(plain.greedy, exact, scorer, k),
        "float32": partial(plain.greedy, _cast(low), scorer, k),
        "kernel": partial(greedy, exact, scorer, k),
    }
    return {name: (exact.pool[loop()[0]], loop) for name, loop in loops.items()}


def _cast(prepared: Prepared) -> Prepared:
    """Every float64 array in float32."""
    rows = prepared.rows
    low: dict[str, Any] = {
        name: value.astype(np.float32)
        for name, value in rows._asdict().items()
        if isinstance(value, np.ndarray)
    }
    visible = rows.visible._replace(seen=rows.visible.seen.astype(np.float32))
    own = rows._replace(**low, visible=visible)
    return replace(prepared, static=prepared.static.astype(np.float32), rows=own)


def agreement(picks: np.ndarray, reference: np.ndarray) -> float:
    """Share of picks that the reference also makes, in whatever order."""
    return float(np.isin(picks, reference).mean())


def compared(
    picks: Mapping[str, np.ndarray],
    seconds: Mapping[str, float],
    evaluator: Evaluator,
    **place: str,
) -> list[dict]:
    """One row an arithmetic: agreement with float64, PSNR in dB and its change, seconds."""
    psnr = {name: float(measured(evaluator, own)["psnr"].mean()) for name, own in picks.items()}
    return [
        {
            **place,
            "arithmetic": name,
            "agreement": agreement(frames, picks["float64"]),
            "psnr": psnr[name],
            "psnr_change": psnr[name] - psnr["float64"],
            "seconds": seconds[name],
        }
        for name, frames in picks.items()
    ]


def compare_arithmetic(
    problem: Problem, scorers: Mapping[str, Scorer], k: int, evaluator: Evaluator, **place: str
) -> list[dict]:
    """The rows of `compared` for every policy."""
    rows = []
    for policy, scorer in scorers.items():
        tried = selections(problem, policy, scorer, k)
        picks = {name: frames for name, (frames, _) in tried.items()}
        seconds = {name: timed(loop) for name, (_, loop) in tried.items()}
        rows += compared(picks, seconds, evaluator, **place, method=policy)
    return rows


def hard_cases(scorers: Mapping[str, Scorer], k: int) -> list[dict]:
    """`compare_arithmetic` on every hard case that has a selection problem."""
    rows = []
    for case in CASES.values():
        if case.make is not None:
            problem = case.make()
            evaluator = on_frames(problem.capture, problem.proxies)
            place = {"part": HARD, "name": case.name}
            rows += compare_arithmetic(problem, scorers, k, evaluator, **place)
    return rows


def trainings(
    scenes: Scenes, trajectories: File, **settings
) -> tuple[dict[str, Network], list[dict], dict[str, float]]:
    """Train on the same labels in both precisions: networks, loss curves, seconds."""
    import torch  # here: every job imports this module

    from fsel.training.imitation import train
    from fsel.training.labelled import training_data

    table = read_table(trajectories)
    data = {
        role: training_data(part, scenes, POLICIES[TRAINED])
        for role, part in table.groupby("role", sort=True)
    }
    sets = data["train"], data.get("validation", [])
    train(*sets, **{**settings, "epochs": 0})  # what torch does once is not timed
    networks, curves, seconds = {}, [], {}
    for name in PRECISIONS:
        started = time.perf_counter()
        arrays, log = train(*sets, dtype=getattr(torch, name), **settings)
        networks[name], seconds[name] = Network(arrays), time.perf_counter() - started
        place = {"part": LOSS, "method": TRAINED, "arithmetic": name}
        log = pd.DataFrame(log)
        log["name"] = log["split"] + " epoch " + log["epoch"].astype(str)
        curves += log[["name", "loss", "agreement"]].assign(**place).to_dict("records")
    return networks, curves, seconds


def precision(
    folders: Files,
    splits: Files,
    weights: Files,
    trajectories: File,
    trained_folders: Files,
    trained_splits: Files,
    table: File,
    numbers: File,
    *,
    labels: Sequence[str],
    problems: Sequence[str],
    scenes: Sequence[str],
    training: Mapping,
    k: int,
    reconstruction: Mapping,
    facts: Mapping,
) -> None:
    """Compare arithmetics on every scene, on hard cases, and in training.

    Args:
        weights: one scorer of each policy.
        trained_folders, trained_splits: captures of the labelled scenes, and their splits.
        table, numbers: receive LaTeX, and part, name, method, arithmetic, agreement, psnr,
            psnr_change, seconds, loss.
        labels: of each capture's dataset.
        problems: `dataset/scene/draw0` of each capture.
        scenes: names of the labelled scenes.
        training: seed, epochs, learning_rate.
    """
    loaded = [Scorer.load(path) for path in weights]
    scorers = {scorer.provenance["policy"]: scorer for scorer in loaded}
    labelled = dict(zip(scenes, zip(trained_folders, trained_splits, strict=True), strict=True))
    trained, curves, seconds = trainings(labelled, trajectories, **training)
    rows, retrained = [], []
    for label, name, folder, split in zip(labels, problems, folders, splits, strict=True):
        problem, targets = Problem.load(folder, split), Split.load(split).targets
        evaluator = evaluators(reconstruction)(problem.capture, targets)
        rows += compare_arithmetic(problem, scorers, k, evaluator, part=label, name=name)
        made = POLICIES[TRAINED].prepare(problem)
        picks = {n: made.pool[greedy(made, own, k)[0]] for n, own in trained.items()}
        place = {"part": TRAINING, "name": name, "method": TRAINED}
        retrained += compared(picks, seconds, evaluator, **place)
        logger.info("%s: %s", name, rows[-1])
    rows += [*hard_cases(scorers, min(k, FEW)), *retrained, *curves]
    result = pd.DataFrame(rows)[[*COLUMNS, "seconds", "loss"]]
    write_csv(result, numbers, form="%.6g")
    write_text(_table(result, k, facts), table)


def loss_gap(result: pd.DataFrame) -> float:
    """Largest relative difference of the two loss curves."""
    curves = result[result["part"] == LOSS].pivot(index="name", columns="arithmetic", values="loss")
    return float((curves["float32"] / curves["float64"] - 1).abs().max())


def _table(result: pd.DataFrame, k: int, facts: Mapping) -> str:
    body, rows = result[result["part"] != LOSS], []
    for (part, method), group in body.groupby(["part", "method"], sort=False):
        means = group.groupby("arithmetic")[["agreement", "psnr_change", "seconds"]].mean()
        means = means.reindex(ARITHMETIC)
        cells = [
            *(_cell(means.loc[name, "agreement"], "{:.3f}") for name in ARITHMETIC[1:]),
            *(_cell(means.loc[name, "psnr_change"], "${:+.3f}$") for name in ARITHMETIC[1:]),
            *(_cell(1e3 * means.loc[name, "seconds"], "{:,.2f}") for name in ARITHMETIC),
        ]
        rows.append([tex(part), tex(POLICIES[method].label), *cells])
    return plain_table(
        [
            *("Captures", "Scorer", "float32", "kernel"),
            *(r"$\Delta$ float32", r"$\Delta$ kernel"),
            *("float64 (ms)", "float32 (ms)", "kernel (ms)"),
        ],
        rows,
        caption=rf"\textbf{{Arithmetic.}} Share of ${k}$ picks that the float64 selection also "
        r"makes, change in PSNR (dB), and time of the greedy loop on one thread, features given; "
        f"means over scenes, hard cases with {min(k, FEW)} picks. Training on the same labels, all "
        f"picks being made by the kernel: loss curves differ by at most "
        f"{100 * loss_gap(result):.2g}\\%, time is that of a training. {made_by(facts)}",
        label="tab:precision",
        columns="ll" + "r" * 7,
    )


def _cell(value: float, form: str) -> str:
    return MISSING if np.isnan(value) else form.format(value)


def _files(experiment: Experiment) -> Values:
    kinds = ["frames", "descriptors"]
    return {
        **specs.evaluated_problems(experiment),
        **inputs.captures(inputs.labelled(experiment), kinds, prefix="trained_"),
        "weights": [experiment.weights("less_is_more")[0], experiment.fsel[0]],
        "trajectories": "<results>/trajectories.parquet",
        "trained_splits": inputs.of_labelled(experiment, "splits"),
    }


def _settings(experiment: Experiment) -> Values:
    config, labels = experiment.config, experiment.labels()
    training = {key: config["training"][key] for key in ("epochs", "learning_rate")}
    return {
        "labels": [labels[dataset] for dataset, _ in experiment.evaluation_scenes],
        "problems": experiment.problems(1),
        "scenes": list(experiment.labelled),
        "training": {"seed": 0, **training},
        "k": config["search"]["k"],
        "reconstruction": experiment.reconstruction,
        "facts": experiment.facts(),
    }


TABLE = Table(
    precision,
    outputs=inputs.table_files("precision"),
    inputs=_files,
    params=_settings,
    size=Size(4000, 30, "reconstruction"),
    category="Numerics",
    title="Arithmetic",
    caption="Selection in float64, float32 and by the compiled loop: picks that agree, change of "
    "PSNR, time; and training in float32 against float64.",
)
