"""Behaviour cloning of ordered subsets, one greedy step at a time (paper, section 3.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch

from fsel.scorer import INPUTS, WIDTH


@dataclass(frozen=True)
class Trajectory:
    """One retained subset as K supervised decisions.

    Attributes:
        features: (K, n, 19) float32 standardised inputs of the n pool frames at each step.
        selectable: (K, n) bool, False once a frame is in the prefix.
        picks: (K,) int64 row picked at each step.
        weight: w_m of Eq. 5.
    """

    features: np.ndarray
    selectable: np.ndarray
    picks: np.ndarray
    weight: float


def train(
    trajectories: Sequence[Trajectory],
    validation: Sequence[Trajectory],
    *,
    seed: int,
    epochs: int,
    learning_rate: float,
    dtype: torch.dtype = torch.float32,
) -> tuple[dict[str, np.ndarray], pd.DataFrame]:
    """Fit the scorer with Adam, one update a trajectory (paper, Eq. 4 and 5, Appendix A.3).

    Args:
        trajectories: training trajectories.
        validation: trajectories of scenes kept apart; only reported, never fitted.
        seed: initialisation and order of presentation.
        epochs: passes over the trajectories.
        learning_rate: Adam's, fixed.
        dtype: arithmetic of the network; float32 is what the paper's scale needs.

    Returns:
        The weights as float32 arrays keyed as in `fsel.scorer`, and a log with one row an epoch
        and set (epoch 0: before the first update): epoch, split, loss, agreement.
    """
    torch.manual_seed(seed)
    network = _network().to(dtype)
    optimizer = torch.optim.Adam(network.parameters(), lr=learning_rate)
    data, held_out = _tensors(trajectories, dtype), _tensors(validation, dtype)
    rng = np.random.default_rng(seed)
    log = _measure(network, 0, data, held_out)
    for epoch in range(1, epochs + 1):
        for index in rng.permutation(len(data)):
            features, selectable, picks, weight = data[index]
            optimizer.zero_grad(set_to_none=True)
            loss = weight * _loss(network, features, selectable, picks)[0]
            loss.backward()
            optimizer.step()
        log += _measure(network, epoch, data, held_out)
    return _weights(network), pd.DataFrame(log)


def _network() -> torch.nn.Sequential:
    return torch.nn.Sequential(
        torch.nn.Linear(INPUTS, WIDTH),
        torch.nn.GELU(),
        torch.nn.Linear(WIDTH, WIDTH),
        torch.nn.GELU(),
        torch.nn.Linear(WIDTH, 1),
    )


def _tensors(trajectories: Sequence[Trajectory], dtype: torch.dtype) -> list[tuple]:
    return [
        (
            torch.from_numpy(t.features).to(dtype),
            torch.from_numpy(t.selectable),
            torch.from_numpy(t.picks),
            t.weight,
        )
        for t in trajectories
    ]


def _loss(network, features, selectable, picks) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean cross-entropy over the steps, and the share of steps whose argmax is the label."""
    logits = network(features).squeeze(-1).masked_fill(~selectable, -torch.inf)
    agreement = (logits.argmax(dim=1) == picks).to(logits.dtype).mean()
    return torch.nn.functional.cross_entropy(logits, picks), agreement


def _measure(network, epoch: int, data: list, held_out: list) -> list[dict]:
    rows = []
    with torch.no_grad():
        for split, part in (("train", data), ("validation", held_out)):
            if part:
                values = [torch.stack(_loss(network, *item[:3])) for item in part]
                loss, agreement = torch.stack(values).mean(dim=0).tolist()
                rows.append({"epoch": epoch, "split": split, "loss": loss, "agreement": agreement})
    return rows


def _weights(network: torch.nn.Sequential) -> dict[str, np.ndarray]:
    weights = {}
    for name, layer in zip(("layer1", "layer2", "layer3"), network[::2], strict=True):
        weights[f"{name}.weight"] = layer.weight.detach().to(torch.float32).numpy().copy()
        weights[f"{name}.bias"] = layer.bias.detach().to(torch.float32).numpy().copy()
    return weights
