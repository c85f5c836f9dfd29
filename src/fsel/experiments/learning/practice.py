"""Learning by reconstruction: policy gradient, and evolution of the last layer.

Both let a network pick for training requests and reconstruct from its picks; labels are not looked
at, but for the targets that judge.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import torch

from fsel.experiments.learning.lessons import Lesson, walked
from fsel.experiments.learning.network import Learned
from fsel.experiments.learning.teaching import log_probability
from fsel.training.refinement import Coefficients, RefineSettings, refine

logger = logging.getLogger(__name__)

Judge = Callable[[Lesson, np.ndarray], float]
"""(lesson, (K,) rows) -> PSNR in dB on the targets of the lesson."""

TEMPERATURE = 0.3  # of the softmax that walks are drawn from


def policy_gradient(
    network: Learned, lessons: Sequence[Lesson], judge: Judge, settings: Mapping, seed: int
) -> None:
    """REINFORCE (Williams 1992): walks are drawn, those above their lesson's mean made likelier.

    Args:
        network: to fit, in place.
        lessons: one is drawn for each update.
        judge: of picks.
        settings: updates, walks (of an update), gradient_rate (Adam's).
        seed: of lessons and walks.
    """
    rng = np.random.default_rng([seed, 2])
    optimizer = torch.optim.Adam(network.parameters(), lr=settings["gradient_rate"])

    def softer(features: torch.Tensor) -> torch.Tensor:
        return network(features) / TEMPERATURE

    for update in range(settings["updates"]):
        lesson = lessons[int(rng.integers(len(lessons)))]
        drawn = partial(_drawn, network, rng)
        walks = [walked(lesson.pairs, lesson.k, drawn) for _ in range(settings["walks"])]
        reward = np.array([judge(lesson, steps.picks) for steps in walks])
        lead = (reward - reward.mean()) / (reward.std() + 1e-6)
        optimizer.zero_grad(set_to_none=True)
        for steps, weight in zip(walks, lead.tolist(), strict=True):
            likely = log_probability(softer, *map(torch.from_numpy, steps))
            (-weight * likely.mean() / len(walks)).backward()
        optimizer.step()
        if update % 20 == 0:
            logger.info("update %d: %.2f dB, spread %.3f", update, reward.mean(), reward.std())


def _drawn(network: Learned, rng: np.random.Generator, features: np.ndarray) -> np.ndarray:
    """Scores with Gumbel noise: their argmax is a draw from the softmax."""
    return network.scores(features) + TEMPERATURE * rng.gumbel(size=len(features))


def evolve(
    network: Learned, lessons: Sequence[Lesson], judge: Judge, settings: Mapping, seed: int
) -> None:
    """CMA-ES on the last layer's weights; the policies of a generation meet the same lessons.

    Args:
        network: whose last layer is changed, in place.
        lessons: practised on.
        judge: of picks.
        settings: generations, population, batch (lessons of a generation), step.
        seed: of the strategy and the batches.
    """
    rng = np.random.default_rng([seed, 3])
    batch = min(settings["batch"], len(lessons))
    batches = [
        rng.choice(len(lessons), batch, replace=False) for _ in range(settings["generations"])
    ]
    known: dict[tuple[int, ...], float] = {}

    def value(lesson: Lesson) -> float:
        picks = walked(lesson.pairs, lesson.k, network.scores).picks
        key = (*lesson.place, *np.sort(picks).tolist())
        if key not in known:
            known[key] = judge(lesson, picks)
        return known[key]

    def objective(asked: Sequence[Coefficients], generation: int) -> np.ndarray:
        met, values = [lessons[i] for i in batches[generation]], []
        for coefficients in asked:
            _set(network, coefficients)
            values.append(np.mean([value(lesson) for lesson in met]))
        text = "generation %d: %.3f dB, the best %.3f"
        logger.info(text, generation, np.mean(values), np.max(values))
        return np.array(values)

    start = {f"w{i}": w for i, w in enumerate(network.last.weight[0].tolist())}
    chosen = {key: settings[key] for key in ("generations", "population", "batch", "step")}
    found, _ = refine(objective, start, tuple(start), RefineSettings(**chosen), seed)
    _set(network, found)


def _set(network: Learned, coefficients: Coefficients) -> None:
    with torch.no_grad():
        network.last.weight[0] = torch.tensor(list(coefficients.values()))
