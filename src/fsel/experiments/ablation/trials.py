"""Scorers trained on other features, or built otherwise, and what their picks are worth."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.experiments.ablation.architectures import MODULES
from fsel.experiments.ablation.architectures.steps import Steps
from fsel.experiments.ablation.extras import EXTRAS, Relations, relations
from fsel.experiments.ablation.walk import PartialWalk, view_inputs
from fsel.files import write_table
from fsel.metrics import METRIC_UNITS, METRICS
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.selector.greedy import Prepared
from fsel.selector.policies import POLICIES
from fsel.selector.walk import follow, pick
from fsel.split import Split
from fsel.training.imitation import imitation, mean_cost, passes
from fsel.training.labelled import Scenes, labelled_problems

logger = logging.getLogger(__name__)

POLICY = POLICIES["ours"]


@dataclass(frozen=True)
class Case:
    """A scorer and what it is shown.

    Attributes:
        module: key of `fsel.experiments.ablation.architectures.MODULES`.
        settings: of that class.
        shown: features whose inputs are not held at zero.
        added: key of `fsel.experiments.ablation.extras.EXTRAS`, or None.
    """

    module: str
    settings: Mapping
    shown: Sequence[str]
    added: str | None

    def walk(self, prepared: Prepared, scene: Relations) -> PartialWalk:
        """The inputs along picks of a problem."""
        extra = None if self.added is None else EXTRAS[self.added]
        return PartialWalk(prepared, scene, self.shown, extra)


def trial(
    case: Case,
    scenes: Scenes,
    trajectories: str | Path,
    validation: Sequence[Mapping],
    output: str | Path,
    *,
    k: int,
    seeds: int,
    epochs: int,
    learning_rate: float,
    config: str,
) -> None:
    """Train a case with several seeds and let it pick frames of validation scenes.

    Args:
        case: what to train.
        scenes: see `fsel.training.labelled.Scenes`, of all label items.
        trajectories: what `fsel.stages.order` wrote.
        validation: one mapping a problem: dataset, scene, draw, path of its split, folder.
        output: receives seed, dataset, scene, draw, picks, and of the training: parameters, loss
            and agreement on the training trajectories after the last pass.
        k: frames to pick.
        seeds, epochs, learning_rate: of the training.
        config: digest of the parameters.
    """
    table = pd.read_parquet(trajectories).query("role == 'train'")
    data = training_steps(case, table, scenes)
    problems = [Problem.load(item["folder"], item["path"]) for item in validation]
    rows = []
    for seed in range(seeds):
        network = trained(case, data, seed=seed, epochs=epochs, learning_rate=learning_rate)
        loss, agreement = mean_cost(network, data, _cost)
        record = {
            "seed": seed,
            "parameters": parameters(network),
            "loss": loss,
            "agreement": agreement,
        }
        logger.info("%s: %s", case, record)
        for item, problem in zip(validation, problems, strict=True):
            place = {key: item[key] for key in ("dataset", "scene", "draw")}
            picks = selected(network, case, problem, k).tolist()
            rows.append({**place, **record, "picks": picks})
    write_table(pd.DataFrame(rows), output, units={"loss": "nats"}, config=config)


def training_steps(case: Case, table: pd.DataFrame, scenes: Scenes) -> list[tuple[Steps, float]]:
    """Every trajectory as the case sees it, and its weight."""
    data = []
    for problem, part in labelled_problems(table, scenes):
        prepared = POLICY.prepare(problem)
        scene = relations(problem, prepared, budget=len(part["picks"].iloc[0]))
        views = torch.from_numpy(view_inputs(scene))
        for row in part.itertuples():
            picks = np.searchsorted(prepared.pool, np.array(row.picks))
            inputs = follow(case.walk(prepared, scene), picks)
            tensors = (torch.from_numpy(array) for array in (*inputs, picks))
            data.append((Steps(*tensors, views), row.weight))
    return data


def trained(
    case: Case,
    data: Sequence[tuple[Steps, float]],
    *,
    seed: int,
    epochs: int,
    learning_rate: float,
) -> torch.nn.Module:
    """The case's scorer, fitted as `fsel.training.imitation.train` does; all kinds by one loop."""
    torch.manual_seed(seed)
    network = MODULES[case.module](**case.settings)
    settings = {"seed": seed, "epochs": epochs, "learning_rate": learning_rate}
    for epoch, _ in passes(network, data, _cost, **settings):
        logger.info("%s, seed %d: %d of %d passes", case.module, seed, epoch, epochs)
    return network


def selected(network: torch.nn.Module, case: Case, problem: Problem, k: int) -> np.ndarray:
    """(k,) int64 frames that a trained scorer picks, in order."""
    prepared = POLICY.prepare(problem)
    scene = relations(problem, prepared, budget=k)
    views = torch.from_numpy(view_inputs(scene))

    def score(features: np.ndarray, selectable: np.ndarray, past: np.ndarray) -> np.ndarray:
        picks = np.append(past, 0)  # the last is yet to be made, and not read
        tensors = (torch.from_numpy(array) for array in (features, selectable, picks))
        with torch.no_grad():
            return network(Steps(*tensors, views))[-1].numpy()

    return prepared.pool[pick(case.walk(prepared, scene), score, k)]


def parameters(network: torch.nn.Module) -> int:
    """Numbers that training fits."""
    return sum(array.numel() for array in network.parameters())


def _cost(network: torch.nn.Module, steps: Steps) -> tuple[torch.Tensor, torch.Tensor]:
    return imitation(network(steps), steps.selectable, steps.picks)


def measure_trials(
    folder: str | Path,
    splits: Sequence[str | Path],
    trials: Mapping[str, str | Path],
    output: str | Path,
    *,
    dataset: str,
    scene: str,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Reconstruct a validation scene from the picks of all trials, sharing one reconstructor.

    Args:
        folder: its canonical capture.
        splits: split.parquet, one a draw.
        trials: name -> what `trial` wrote.
        output: receives method (the name), seed, draw, k, metrics averaged over the targets.
        dataset, scene: which picks are its own.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    tables = [pd.read_parquet(path).assign(method=name) for name, path in trials.items()]
    picks = pd.concat(tables).query("dataset == @dataset and scene == @scene")
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    rows = []
    for draw, path in enumerate(splits):
        targets = Split.load(path).targets
        evaluate = Evaluator.on_frames(reconstructor, targets)
        known: dict[tuple, np.ndarray] = {}
        for row in picks[picks["draw"] == f"draw{draw}"].itertuples():
            subset = tuple(sorted(row.picks))
            if subset not in known:
                known[subset] = evaluate(np.array(subset))
            rows.append((row.method, row.seed, draw, len(subset), *known[subset]))
        logger.info("draw %d: %d distinct subsets", draw, len(known))
    table = pd.DataFrame(rows, columns=["method", "seed", "draw", "k", *METRICS])
    write_table(table, output, units=METRIC_UNITS, config=config)
