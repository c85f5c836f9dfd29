"""Behaviour cloning of ordered subsets, one greedy step at a time (paper, section 3.5)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from fsel.core.files import Columns, by_column
from fsel.features.columns import INPUTS
from fsel.features.static import SIGNS
from fsel.selectors.policies import Policy
from fsel.selectors.rollout import Rollout, follow
from fsel.selectors.scorer import SHAPES, WIDTH, Linear
from fsel.training.labelled import Scenes, labelled_problems

SUM_SCALE = 0.1  # of the untrained sum in a score that begins as it, and of the random rest

Cost = Callable[..., tuple[torch.Tensor, torch.Tensor]]
"""(network, what a trajectory holds) -> loss to minimise, and agreement with the label."""


@dataclass(frozen=True)
class Trajectory:
    """One retained subset as K supervised decisions.

    Attributes:
        features: (K, n, 19) float32 inputs of the n pool frames at each step.
        selectable: (K, n) bool, False once a frame is picked.
        picks: (K,) int64 row picked at each step.
        weight: w_m of Eq. 5.
    """

    features: np.ndarray
    selectable: np.ndarray
    picks: np.ndarray
    weight: float


def training_data(trajectories: Columns, scenes: Scenes, policy: Policy) -> list[Trajectory]:
    """Return the ordered subsets that `fsel.stages.order` wrote, as the policy will see them."""
    data = []
    for problem, rows in labelled_problems(trajectories, scenes):
        prepared = policy.prepare(problem)
        for row in rows:
            picks = np.searchsorted(prepared.pool, np.array(row["picks"]))
            features, selectable = follow(Rollout(prepared), picks)
            data.append(Trajectory(features, selectable, picks, row["weight"]))
    return data


def train(
    trajectories: Sequence[Trajectory],
    validation: Sequence[Trajectory],
    *,
    seed: int,
    epochs: int,
    learning_rate: float,
    from_sum: bool = False,
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Fit the scorer with Adam, one update a trajectory (paper, Eq. 4 and 5, Appendix A.3).

    Args:
        validation: of scenes kept apart; only reported.
        seed: of the initialisation and the order of presentation.
        learning_rate: Adam's, fixed.
        from_sum: whether the scorer begins as the untrained sum, in place of random weights.

    Returns:
        Float32 arrays as `fsel.selectors.scorer.SHAPES`, and a log with one row an epoch (0: before
        the first update) and set: epoch, split, loss, agreement, of `train` as met in the pass.
    """
    torch.manual_seed(seed)
    network = perceptron(WIDTH)
    if from_sum:
        begin_as_sum(network)
    data, held_out = _tensors(trajectories), _tensors(validation)
    log = []
    steps = passes(network, data, _cost, seed=seed, epochs=epochs, learning_rate=learning_rate)
    for epoch, met in steps:
        values = {"train": met or mean_cost(network, data, _cost)}
        if held_out:
            values["validation"] = mean_cost(network, held_out, _cost)
        for split, (loss, agreement) in values.items():
            log.append({"epoch": epoch, "split": split, "loss": loss, "agreement": agreement})
    return _weights(network), by_column(log)


def passes(
    network: torch.nn.Module,
    data: Sequence[tuple],
    cost: Cost,
    *,
    seed: int,
    epochs: int,
    learning_rate: float,
) -> Iterator[tuple[int, list[float]]]:
    """Fit a network in place by Adam, one update a trajectory, whose last entry is its weight w_m,
    the others are for `cost`; yield the passes made, and the mean loss and agreement of the last,
    none at first."""
    # not fused it takes MKL's square root, which ends in other digits on other processors
    optimizer = torch.optim.Adam(network.parameters(), lr=learning_rate, fused=True)
    rng = np.random.default_rng(seed)
    yield 0, []
    for epoch in range(1, epochs + 1):
        met = []
        for index in rng.permutation(len(data)):
            *item, weight = data[index]
            optimizer.zero_grad(set_to_none=True)
            loss, agreement = cost(network, *item)
            (weight * loss).backward()
            optimizer.step()
            met.append(torch.stack([loss.detach(), agreement]))
        yield epoch, torch.stack(met).mean(dim=0).tolist()


def mean_cost(network: torch.nn.Module, data: Sequence[tuple], cost: Cost) -> tuple[float, float]:
    """Mean loss in nats and mean agreement over trajectories, unweighted."""
    with torch.no_grad():
        values = [torch.stack(cost(network, *item[:-1])) for item in data]
    loss, agreement = torch.stack(values).mean(dim=0).tolist()
    return loss, agreement


def perceptron(width: int, inputs: int = INPUTS) -> torch.nn.Sequential:
    """Build three layers with exact GELU; with width 64 the paper's scorer (Appendix A.3)."""
    return torch.nn.Sequential(
        torch.nn.Linear(inputs, width),
        torch.nn.GELU(),
        torch.nn.Linear(width, width),
        torch.nn.GELU(),
        torch.nn.Linear(width, 1),
    )


def begin_as_sum(network: torch.nn.Sequential) -> None:
    """Let the first two units of each layer carry the untrained sum: gelu(x) - gelu(-x) is x."""
    first, _, second, _, last = network
    pair, signs = torch.tensor([1.0, -1.0]), torch.tensor(Linear(SIGNS).vector).float()
    with torch.no_grad():
        first.weight[:2], first.bias[:2] = torch.outer(pair, signs), 0
        second.weight[:2], second.bias[:2] = 0, 0
        second.weight[:2, :2] = torch.outer(pair, pair)
        last.weight *= SUM_SCALE
        last.weight[0, :2] = SUM_SCALE * pair


def imitation(
    scores: torch.Tensor, selectable: torch.Tensor, picks: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the mean cross-entropy over K steps of (K, n) scores, and the share whose argmax is
    the label; rows that are not selectable are out of the softmax."""
    logits = scores.masked_fill(~selectable, -torch.inf)
    agreement = (logits.argmax(dim=1) == picks).to(logits.dtype).mean()
    return torch.nn.functional.cross_entropy(logits, picks), agreement


def _tensors(trajectories: Sequence[Trajectory]) -> list[tuple]:
    return [
        (*map(torch.from_numpy, (t.features, t.selectable, t.picks)), t.weight)
        for t in trajectories
    ]


def _cost(network, features, selectable, picks) -> tuple[torch.Tensor, torch.Tensor]:
    return imitation(network(features).squeeze(-1), selectable, picks)


def _weights(network: torch.nn.Sequential) -> dict[str, np.ndarray]:
    values = [value.detach().numpy().copy() for value in network.parameters()]
    return dict(zip(SHAPES, values, strict=True))
