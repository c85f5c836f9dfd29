"""Learning from labels alone: imitation, DAgger, ranking of whole subsets and of swaps.

A label says which frames, not in what order. The steps of imitation go through a good subset in a
random order, and every frame of it that is left is right. In the rule's order, those left at the
end would be what the rule ranks lowest, and to contradict it would be learned.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import torch

from fsel.experiments.learning.inputs import COLUMNS
from fsel.experiments.learning.lessons import Lesson, Score, Steps, by_rule, walked
from fsel.experiments.learning.network import Learned
from fsel.training.imitation import Cost, passes

logger = logging.getLogger(__name__)

ROUNDS = 2  # of DAgger, each a walk through every lesson
SCALE = 1.0  # nats of a whole subset's mean step that a decibel should part two subsets by

Item = tuple[torch.Tensor, ...]
"""Features, selectable, wanted or picks, ...; see the costs."""


def imitate(network: Learned, lessons: Sequence[Lesson], settings: Mapping, seed: int) -> None:
    """Fit a network to the best subsets of every lesson, walked through in a random order.

    Args:
        network: to fit, in place.
        lessons: labelled requests.
        settings: kept (subsets of a lesson), epochs, learning_rate.
        seed: of the orders of picks and of presentation.
    """
    fit(network, all_taught(lessons, settings, seed), any_of, settings, seed)


def dagger(network: Learned, lessons: Sequence[Lesson], settings: Mapping, seed: int) -> None:
    """DAgger (Ross et al. 2011): label what the network itself runs into, and fit to all of it.

    Where a network has come to, the good subset that shares most of its picks says what is wanted.
    Arguments as in `imitate`.
    """
    taught = all_taught(lessons, settings, seed)
    for number in range(ROUNDS):
        taught += [own_steps(lesson, network.scores, settings["kept"]) for lesson in lessons]
        fit(network, taught, any_of, settings, seed + number)


def rank(network: Learned, lessons: Sequence[Lesson], settings: Mapping, seed: int) -> None:
    """Rank whole subsets: a good one above a bad one of the same lesson, by a margin.

    A subset's score is its mean log-probability a step; the margin is what parts the two in dB.
    Arguments as in `imitate`; `kept` pairs a lesson.
    """
    rng = np.random.default_rng([seed, 1])
    pairs = [pair for lesson in lessons for pair in ranked_pairs(lesson, settings["kept"], rng)]
    fit(network, pairs, above, settings, seed)


def rank_swaps(network: Learned, lessons: Sequence[Lesson], settings: Mapping, seed: int) -> None:
    """Rank the two frames that part subsets which differ in one, beside what they share.

    A search by swaps has measured many such pairs.

    Args:
        network: to fit, in place.
        lessons: labelled requests.
        settings: swaps (pairs of a lesson), swap_epochs, learning_rate.
        seed: of the pairs and the order of presentation.
    """
    rng = np.random.default_rng([seed, 4])
    items = [swapped(lesson, settings["swaps"], rng) for lesson in lessons]
    often = dict(settings) | {"epochs": settings["swap_epochs"]}
    fit(network, [item for item in items if len(item[1])], better, often, seed)


def fit(network: Learned, items: Sequence[Item], cost: Cost, settings: Mapping, seed: int) -> None:
    """Adam, one update an item, as `fsel.training.imitation.passes` does.

    Args:
        network: to fit, in place.
        items: what the cost takes.
        cost: `any_of` or `above`.
        settings: epochs, learning_rate.
        seed: of the order of presentation.
    """
    weighted = [(*item, 1.0) for item in items]
    made = passes(
        network,
        weighted,
        cost,
        seed=seed,
        epochs=settings["epochs"],
        learning_rate=settings["learning_rate"],
    )
    for epoch, met in made:
        if met:
            logger.info("pass %d over %d items: %.4f, %.3f", epoch, len(items), *met)


def all_taught(lessons: Sequence[Lesson], settings: Mapping, seed: int) -> list[Item]:
    """`taught_steps` of all lessons, arguments as in `imitate`."""
    rng = np.random.default_rng([seed, 5])
    return [item for one in lessons for item in taught_steps(one, settings["kept"], rng)]


def taught_steps(lesson: Lesson, kept: int, rng: np.random.Generator) -> Iterator[Item]:
    """Features, selectable and wanted of a lesson's best subsets, each in a random order."""
    for subset in lesson.subsets[:kept]:
        order = rng.random(len(lesson.pairs.prepared.pool))
        steps = walked(lesson.pairs, lesson.k, lambda _, given=order: given, subset)
        member = np.zeros(steps.selectable.shape[1], bool)
        member[subset] = True
        yield _tensors(steps, steps.selectable & member)


def own_steps(lesson: Lesson, score: Score, kept: int) -> Item:
    """Features, selectable and wanted along a scorer's own picks."""
    steps = walked(lesson.pairs, lesson.k, score)
    good = np.zeros((min(kept, len(lesson.subsets)), steps.selectable.shape[1]), bool)
    for row, subset in zip(good, lesson.subsets, strict=False):
        row[subset] = True
    shared = np.cumsum(good[:, steps.picks], axis=1)
    before = np.column_stack([np.zeros(len(good), int), shared[:, :-1]])
    # of subsets that share as many picks, the first is the best
    return _tensors(steps, steps.selectable & good[before.argmax(axis=0)])


def ranked_pairs(lesson: Lesson, kept: int, rng: np.random.Generator) -> Iterator[Item]:
    """Features, selectable and picks of a good subset and a worse one, and their gap in dB."""
    worse = np.arange(len(lesson.subsets) // 2, len(lesson.subsets))
    for good in range(min(kept, len(lesson.subsets) // 2)):
        bad = int(rng.choice(worse))
        item: list[torch.Tensor] = []
        for row in (good, bad):
            steps = walked(lesson.pairs, lesson.k, by_rule, lesson.subsets[row])
            item += _tensors(steps, steps.picks)
        gap = lesson.psnr[good] - lesson.psnr[bad]
        yield (*item, torch.tensor(gap, dtype=torch.float32))


def swapped(lesson: Lesson, most: int, rng: np.random.Generator) -> Item:
    """Pairs of a lesson's subsets that differ in one frame.

    Returns:
        (S, 2, 1 + F) inputs of the better and the worse frame, at every step of the rule through
        what the two subsets share, and (S,) their gap in dB.
    """
    n = len(lesson.pairs.prepared.pool)
    member = np.zeros((len(lesson.subsets), n), int)
    np.put_along_axis(member, lesson.subsets, 1, axis=1)
    good, bad = np.nonzero(np.triu(member @ member.T == lesson.k - 1, 1))
    chosen = rng.permutation(len(good))[:most]
    features = [np.zeros((0, 2, 1 + len(COLUMNS)), np.float32)]
    gaps = [np.zeros(0, np.float32)]
    for i, j in zip(good[chosen], bad[chosen], strict=True):
        come, go = (np.flatnonzero(member[a] > member[b])[0] for a, b in ((i, j), (j, i)))
        rest = np.flatnonzero(member[i] & member[j])
        steps = walked(lesson.pairs, lesson.k, by_rule, rest)
        features.append(steps.features[:, [come, go]])
        gap = np.float32(lesson.psnr[i] - lesson.psnr[j])
        gaps.append(np.full(len(steps.picks), gap))
    return torch.from_numpy(np.concatenate(features)), torch.from_numpy(np.concatenate(gaps))


def _tensors(steps: Steps, labels: np.ndarray) -> Item:
    arrays = (steps.features, steps.selectable, labels)
    return tuple(torch.from_numpy(array) for array in arrays)


def any_of(
    network: torch.nn.Module,
    features: torch.Tensor,
    selectable: torch.Tensor,
    wanted: torch.Tensor,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean over the steps of minus the log-probability of picking any wanted row.

    Args:
        network: to score with.
        features: (K, n, 1 + F); selectable, wanted: (K, n) bool, some row wanted at every step.

    Returns:
        It, and the share of steps whose best-scored row is wanted.
    """
    logits = network(features).masked_fill(~selectable, -torch.inf)
    right = logits.masked_fill(~wanted, -torch.inf).logsumexp(dim=1)
    best = logits.argmax(dim=1, keepdim=True)
    agreement = wanted.gather(1, best).to(logits.dtype).mean()
    return (logits.logsumexp(dim=1) - right).mean(), agreement


def above(network: torch.nn.Module, *item: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """How far a good subset's score is from being above a worse one's by the margin.

    Args:
        network: to score with.
        item: see `ranked_pairs`.

    Returns:
        log(1 + exp(margin - lead)), and whether the good one leads.
    """
    *both, gap = item
    good, bad = (log_probability(network, *part).mean() for part in (both[:3], both[3:]))
    lead = good - bad
    return torch.nn.functional.softplus(SCALE * gap - lead), (lead > 0).to(lead.dtype)


def better(
    network: torch.nn.Module, features: torch.Tensor, gaps: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """How improbable it is that better frames win against worse ones, by the softmax of two.

    Args:
        network: to score with.
        features, gaps: see `swapped`; each pair counts by its gap.

    Returns:
        Mean of gap times minus the log-probability, over the mean gap; and the share of pairs, by
        their gaps, in which the better one leads.
    """
    scores = network(features)
    lead, weight = scores[:, 0] - scores[:, 1], gaps / gaps.mean().clamp(min=1e-6)
    return (weight * torch.nn.functional.softplus(-lead)).mean(), (weight * (lead > 0)).mean()


def log_probability(
    score: Callable[[torch.Tensor], torch.Tensor],
    features: torch.Tensor,
    selectable: torch.Tensor,
    picks: torch.Tensor,
) -> torch.Tensor:
    """(K,) of each of (K,) picks among the rows that were left."""
    logits = score(features).masked_fill(~selectable, -torch.inf)
    return torch.log_softmax(logits, dim=1).gather(1, picks[:, None])[:, 0]
