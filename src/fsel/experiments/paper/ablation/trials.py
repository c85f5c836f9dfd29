"""Scorers trained on other features, or built otherwise, and what their picks are worth."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_table
from fsel.core.problem import Problem
from fsel.experiments.paper.ablation.extras import EXTRAS, Extra, Relations, relations
from fsel.experiments.scheme import Trials, every_draw
from fsel.features.columns import NAMES
from fsel.selectors.greedy import Prepared, standardise
from fsel.selectors.policies import POLICIES
from fsel.selectors.rollout import Rollout, follow, pick

if TYPE_CHECKING:
    import torch  # a third of the time of a short job

    from fsel.experiments.paper.ablation.architectures import Steps
    from fsel.training.labelled import Scenes

logger = logging.getLogger(__name__)

POLICY = POLICIES["less_is_more"]


class PartialRollout(Rollout):
    """A `Rollout` with inputs that are not `shown` at zero, or three further features in place."""

    def __init__(
        self, prepared: Prepared, scene: Relations, shown: Sequence[str], added: Extra | None
    ) -> None:
        super().__init__(prepared)
        self._scene, self._added = scene, added
        self._shown = np.isin(NAMES, list(shown)).astype(np.float32)

    def inputs(self) -> np.ndarray:
        """(n, 19) float32 inputs at the present step."""
        values = super().inputs()
        values *= self._shown
        if self._added is not None:
            raw = self._added.raw(self._scene, self.picked)
            values[:, self._added.inputs] = self._added.scale(raw, self.selectable)
        return values


def view_inputs(scene: Relations) -> np.ndarray:
    """(n, O, 3) float32 distance, angle and likeness to each proxy, z-scores over all pairs."""
    values = np.stack([scene.distance, scene.angle, scene.likeness], axis=-1)
    return standardise(values.reshape(-1, 3)).reshape(values.shape).astype(np.float32)


@dataclass(frozen=True)
class TrialCase:
    """A scorer, key of `architectures.MODULES` with its settings; the features whose inputs are
    `shown`, not zero; and a key of `extras.EXTRAS`, or None."""

    module: str
    settings: Mapping
    shown: Sequence[str]
    added: str | None

    def rollout(self, prepared: Prepared, scene: Relations) -> PartialRollout:
        """Return the inputs along picks of a problem."""
        extra = None if self.added is None else EXTRAS[self.added]
        return PartialRollout(prepared, scene, self.shown, extra)


def trial_case(
    folders: Files,
    splits: Files,
    trajectories: File,
    validation_folders: Files,
    validation_splits: Files,
    picks: File,
    *,
    trial: str,
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

    `validation_splits` are of every draw of each of the captures; `picks` receives the picks,
    parameters, and loss and agreement on the training trajectories after the last pass.
    """
    from fsel.training.imitation import mean_cost  # here and below: torch is slow to import

    tried = TrialCase(**case)
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
        record = {"method": trial, "seed": seed, "k": k, "loss": loss, "agreement": agreement}
        record["parameters"] = sum(array.numel() for array in network.parameters())
        logger.info("%s: %s", tried, record)
        for name, problem in zip(problems, validation, strict=True):
            dataset, scene, draw = name.split("/")
            place = {"dataset": dataset, "scene": scene, "draw": int(draw.removeprefix("draw"))}
            rows.append({**place, **record, "frame": selected(network, tried, problem, k)})
    made = pd.DataFrame(rows).explode("frame").astype({"frame": int})
    write_table(made, picks, units={"loss": "nats"}, config=config)


def training_steps(
    case: TrialCase, table: pd.DataFrame, scenes: Scenes
) -> list[tuple[Steps, float]]:
    """Return every trajectory as the case sees it, and its weight."""
    import torch

    from fsel.experiments.paper.ablation.architectures import Steps
    from fsel.training.labelled import labelled_problems

    data = []
    for problem, part in labelled_problems(table, scenes):
        prepared = POLICY.prepare(problem)
        scene = relations(problem, prepared, budget=len(part[0]["picks"]))
        views = torch.from_numpy(view_inputs(scene))
        for row in part:
            picks = np.searchsorted(prepared.pool, np.array(row["picks"]))
            arrays = (*follow(case.rollout(prepared, scene), picks), picks)
            features, selectable, rows = map(torch.from_numpy, arrays)
            data.append((Steps(features, selectable, rows, views), row["weight"]))
    return data


def trained(
    case: TrialCase,
    data: Sequence[tuple[Steps, float]],
    *,
    seed: int,
    epochs: int,
    learning_rate: float,
) -> torch.nn.Module:
    """Fit the case's scorer as `fsel.training.imitation.train` does; all kinds by one loop."""
    import torch

    from fsel.experiments.paper.ablation.architectures import MODULES
    from fsel.training.imitation import passes

    torch.manual_seed(seed)
    network = MODULES[case.module](**case.settings)
    losses = passes(network, data, _cost, seed=seed, epochs=epochs, learning_rate=learning_rate)
    for epoch, _ in losses:
        logger.info("%s, seed %d: %d of %d passes", case.module, seed, epoch, epochs)
    return network


def selected(network: torch.nn.Module, case: TrialCase, problem: Problem, k: int) -> np.ndarray:
    """Return the (k,) int64 frames that a trained scorer picks, in order."""
    import torch

    from fsel.experiments.paper.ablation.architectures import Steps

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


def _cost(network: torch.nn.Module, steps: Steps) -> tuple[torch.Tensor, torch.Tensor]:
    from fsel.training.imitation import imitation

    return imitation(network(steps), steps.selectable, steps.picks)


TRIALS = Trials(every_draw)
