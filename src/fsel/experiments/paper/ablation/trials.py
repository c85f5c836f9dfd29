"""Scorers trained on other features, or built otherwise, and what their picks are worth."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import measure, measured_units
from fsel.experiments.paper.ablation.extras import EXTRAS, Relations, relations
from fsel.experiments.paper.ablation.rollout import PartialRollout, view_inputs
from fsel.reconstruct import reconstructor_of
from fsel.selector.greedy import Prepared
from fsel.selector.policies import POLICIES
from fsel.selector.rollout import follow, pick
from fsel.utils.files import File, Files, read_table, write_table

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
