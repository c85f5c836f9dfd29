"""Scorers trained on other features, or built otherwise, and what their picks are worth."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import measure, measured_units
from fsel.experiments import specs
from fsel.experiments.paper.ablation import cases
from fsel.experiments.paper.ablation.extras import EXTRAS, Relations, relations
from fsel.experiments.paper.ablation.rollout import PartialRollout, view_inputs
from fsel.experiments.specs import Values
from fsel.reconstruct import reconstructor_of
from fsel.selector.greedy import Prepared
from fsel.selector.policies import POLICIES
from fsel.selector.rollout import follow, pick
from fsel.utils.files import File, Files, read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job

if TYPE_CHECKING:
    import torch  # a third of the time of a short job

    from fsel.experiments.paper.ablation.architectures.steps import Steps
    from fsel.training.labelled import Scenes

logger = logging.getLogger(__name__)

POLICY = POLICIES["less_is_more"]


@dataclass(frozen=True)
class Case:
    """A scorer and what it is shown.

    Attributes:
        module: key of `fsel.experiments.paper.ablation.architectures.MODULES`.
        settings: of that class.
        shown: features whose inputs are not held at zero.
        added: key of `fsel.experiments.paper.ablation.extras.EXTRAS`, or None.
    """

    module: str
    settings: Mapping
    shown: Sequence[str]
    added: str | None

    def rollout(self, prepared: Prepared, scene: Relations) -> PartialRollout:
        """The inputs along picks of a problem."""
        extra = None if self.added is None else EXTRAS[self.added]
        return PartialRollout(prepared, scene, self.shown, extra)


def trial(
    folders: Files,
    splits: Files,
    trajectories: File,
    validation_folders: Files,
    validation_splits: Files,
    picks: File,
    *,
    case: Mapping,
    scenes: Sequence[str],
    problems: Sequence[str],
    k: int,
    seeds: int,
    epochs: int,
    learning_rate: float,
    config: str,
) -> None:
    """Train a case with several seeds and let it pick frames of validation scenes.

    Args:
        folders, splits: canonical captures of the labelled scenes, and their splits.
        validation_folders: canonical captures of the validation scenes.
        validation_splits: split.parquet of every draw of each of them.
        picks: receives seed, dataset, scene, draw, picks, and of the training: parameters, loss
            and agreement on the training trajectories after the last pass.
        case: what to train, see `Case`.
        scenes: names of the labelled scenes.
        problems: `dataset/scene/draw0` of each of `validation_splits`.
        seeds, epochs, learning_rate: of the training.
    """
    from fsel.training.imitation import mean_cost  # here and below: torch is slow to import

    tried = Case(**case)
    table = read_table(trajectories).query("role == 'train'")
    labelled = dict(zip(scenes, zip(folders, splits, strict=True), strict=True))
    data = training_steps(tried, table, labelled)
    draws = len(validation_splits) // len(validation_folders)
    repeated = [folder for folder in validation_folders for _ in range(draws)]
    validation = [Problem.load(*pair) for pair in zip(repeated, validation_splits, strict=True)]
    rows = []
    for seed in range(seeds):
        network = trained(tried, data, seed=seed, epochs=epochs, learning_rate=learning_rate)
        loss, agreement = mean_cost(network, data, _cost)
        record = {
            "seed": seed,
            "parameters": parameters(network),
            "loss": loss,
            "agreement": agreement,
        }
        logger.info("%s: %s", tried, record)
        for name, problem in zip(problems, validation, strict=True):
            place = dict(zip(("dataset", "scene", "draw"), name.split("/"), strict=True))
            frames = selected(network, tried, problem, k).tolist()
            rows.append({**place, **record, "picks": frames})
    write_table(pd.DataFrame(rows), picks, units={"loss": "nats"}, config=config)


def training_steps(case: Case, table: pd.DataFrame, scenes: Scenes) -> list[tuple[Steps, float]]:
    """Every trajectory as the case sees it, and its weight."""
    import torch

    from fsel.experiments.paper.ablation.architectures.steps import Steps
    from fsel.training.labelled import labelled_problems

    data = []
    for problem, part in labelled_problems(table, scenes):
        prepared = POLICY.prepare(problem)
        scene = relations(problem, prepared, budget=len(part["picks"].iloc[0]))
        views = torch.from_numpy(view_inputs(scene))
        for row in part.itertuples():
            picks = np.searchsorted(prepared.pool, np.array(row.picks))
            arrays = (*follow(case.rollout(prepared, scene), picks), picks)
            features, selectable, rows = (torch.from_numpy(array) for array in arrays)
            data.append((Steps(features, selectable, rows, views), row.weight))
    return data


def trained(
    case: Case, data: Sequence[tuple[Steps, float]], *, seed: int, epochs: int, learning_rate: float
) -> torch.nn.Module:
    """The case's scorer, fitted as `fsel.training.imitation.train` does; all kinds by one loop."""
    import torch

    from fsel.experiments.paper.ablation.architectures import MODULES
    from fsel.training.imitation import passes

    torch.manual_seed(seed)
    network = MODULES[case.module](**case.settings)
    losses = passes(network, data, _cost, seed=seed, epochs=epochs, learning_rate=learning_rate)
    for epoch, _ in losses:
        logger.info("%s, seed %d: %d of %d passes", case.module, seed, epoch, epochs)
    return network


def selected(network: torch.nn.Module, case: Case, problem: Problem, k: int) -> np.ndarray:
    """(k,) int64 frames that a trained scorer picks, in order."""
    import torch

    from fsel.experiments.paper.ablation.architectures.steps import Steps

    prepared = POLICY.prepare(problem)
    scene = relations(problem, prepared, budget=k)
    views = torch.from_numpy(view_inputs(scene))

    def score(features: np.ndarray, selectable: np.ndarray, past: np.ndarray) -> np.ndarray:
        picks = np.append(past, 0)  # the last is yet to be made, and not read
        seen, open_rows, rows = map(torch.from_numpy, (features, selectable, picks))
        with torch.no_grad():
            scores: np.ndarray = network(Steps(seen, open_rows, rows, views))[-1].numpy()
        return scores

    return prepared.pool[pick(case.rollout(prepared, scene), score, k)]


def parameters(network: torch.nn.Module) -> int:
    """Numbers that training fits."""
    return sum(array.numel() for array in network.parameters())


def _cost(network: torch.nn.Module, steps: Steps) -> tuple[torch.Tensor, torch.Tensor]:
    from fsel.training.imitation import imitation

    return imitation(network(steps), steps.selectable, steps.picks)


def evaluate_trials(
    folder: File,
    splits: Files,
    trials: Files,
    evaluation: File,
    *,
    names: Sequence[str],
    dataset: str,
    scene: str,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Reconstruct a validation scene from the picks of all trials, sharing one reconstructor.

    Args:
        folder: its canonical capture.
        trials: what `trial` wrote.
        evaluation: receives draw, method (the name), seed, k and the columns of
            `fsel.evaluation.measuring.measure`.
        names: of the trials.
        dataset, scene: which picks are its own.
    """
    every = zip(names, trials, strict=True)
    picks = pd.concat([read_table(path).assign(method=name) for name, path in every])
    picks = picks.query("dataset == @dataset and scene == @scene")
    picks = picks.assign(k=picks["picks"].map(len), frame=picks["picks"]).explode("frame")
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    picks["draw"] = picks["draw"].str.removeprefix("draw").astype(int)
    tables = []
    for draw, part in picks.groupby("draw"):
        targets = Split.load(splits[int(draw)]).targets
        tables.append(measure(Evaluator.on_frames(reconstructor, targets), part).assign(draw=draw))
    write_table(pd.concat(tables), evaluation, units=measured_units(), config=config)


def trial_files(experiment: Experiment, table: str) -> list[str]:
    """The picks of every case of a table."""
    names = cases.cases(experiment, table)
    return [f"<results>/trials/{table}/{name}.parquet" for name in names]


def trial_inputs(experiment: Experiment, table: str) -> Values:
    """Collect what the table's function reads."""
    scenes = cases.scenes(experiment, table)
    return {
        "evaluations": inputs.of_scenes(scenes, f"{{reconstructor}}{table}.parquet"),
        "trials": trial_files(experiment, table),
    }


def facts(experiment: Experiment, table: str) -> Callable[[Any], dict[str, Any]]:
    """Return the function that gives the facts of the table's caption."""
    told = specs.facts_about(experiment, specs.datasets_of(cases.scenes(experiment, table)))
    epochs = experiment.config["trials"]["epochs"]
    return lambda wildcards: {**told(wildcards), "epochs": epochs}


def jobs(table: str) -> list[Job]:
    """The rules that train and try a table's cases, and measure what they pick."""

    def read(experiment: Experiment) -> Values:
        scenes = cases.scenes(experiment, table)
        draws, kinds = range(experiment.config["draws"]), ["frames", "descriptors"]
        return {
            **inputs.captures(inputs.labelled(experiment), kinds),
            **inputs.captures(inputs.joined(scenes), kinds, prefix="validation_"),
            "trajectories": "<results>/trajectories.parquet",
            "splits": inputs.of_labelled(experiment, "splits"),
            "validation_splits": inputs.of_scenes(scenes, "split.parquet", draws),
        }

    def settings(experiment: Experiment) -> Values:
        every, config = cases.cases(experiment, table), experiment.config
        scenes = inputs.joined(cases.scenes(experiment, table))
        return {
            "case": lambda wildcards: every[wildcards.trial],
            "k": experiment.budget_near(cases.BUDGETS[table]),
            "scenes": list(experiment.labelled),
            "problems": [f"{scene}/draw{n}" for scene in scenes for n in range(config["draws"])],
            "learning_rate": config["training"]["learning_rate"],
            "seeds": config["trials"]["seeds"],
            "epochs": config["trials"]["epochs"],
        }

    trained = Job(
        trial,
        name=f"trial_{table}",
        outputs={"picks": f"<results>/trials/{table}/{{trial}}.parquet"},
        message=f"Training {table} {{wildcards.trial}} and selecting with it",
        inputs=read,
        params=settings,
        size=Size(4000, 120),
    )
    evaluated = Job(
        evaluate_trials,
        name=f"evaluate_{table}",
        outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}{table}.parquet"},
        message=f"Reconstructing {{wildcards.dataset}}/{{wildcards.scene}} from picks of {table}",
        inputs=lambda experiment: {
            **specs.of_draws(experiment),
            "trials": trial_files(experiment, table),
        },
        params=lambda experiment: {
            "names": list(cases.cases(experiment, table)),
            "reconstruction": experiment.reconstruction_of,
        },
        size=Size(4000, 60, "reconstruction"),
    )
    return [trained, evaluated]
