"""A scorer that is learned, alone or added to the rule, and its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file

from fsel.experiments.learning.inputs import COLUMNS, shown
from fsel.files import atomic
from fsel.training.imitation import perceptron

WIDTH = 64
RULE = 2.0  # nats that a deviation of the rule's score counts, before it is learned how many


class Learned(torch.nn.Module):
    """The paper's perceptron on some groups of inputs.

    Args:
        groups: keys of `fsel.experiments.learning.inputs.GROUPS` that are shown.
        on_rule: whether it is added to the rule's score; before it has learned anything it then is
            the rule.
    """

    def __init__(self, groups: Sequence[str], on_rule: bool) -> None:
        super().__init__()
        self.body = perceptron(WIDTH, len(COLUMNS))
        self.register_buffer("shown", torch.from_numpy(shown(groups)).float())
        self.rule = torch.nn.Parameter(torch.tensor(RULE * on_rule), requires_grad=on_rule)
        if on_rule:
            torch.nn.init.zeros_(self.last.weight)
            torch.nn.init.zeros_(self.last.bias)

    @property
    def last(self) -> torch.nn.Linear:
        """The last layer."""
        layer = self.body[-1]
        assert isinstance(layer, torch.nn.Linear)
        return layer

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """(...) scores of (..., 1 + F) inputs."""
        learned = self.body(features[..., 1:] * self.shown).squeeze(-1)
        return learned + self.rule * features[..., 0]

    def scores(self, features: np.ndarray) -> np.ndarray:
        """(n,) scores of (n, 1 + F) inputs."""
        with torch.no_grad():
            return self(torch.from_numpy(features)).numpy()


Networks = Mapping[str, Sequence[Learned]]
"""Name of a case -> its networks, one a training seed."""


def save(networks: Networks, path: str | Path) -> None:
    """Write networks; equal ones are equal files."""
    arrays = {
        f"{name}/{seed}/{key}": value.contiguous()
        for name, seeds in networks.items()
        for seed, network in enumerate(seeds)
        for key, value in network.state_dict().items()
    }
    with atomic(path) as temporary:
        save_file(arrays, temporary)


def load(path: str | Path) -> dict[str, list[Learned]]:
    """What `save` wrote."""
    states: dict[str, dict[int, dict[str, torch.Tensor]]] = {}
    for full, value in load_file(path).items():
        name, seed, key = full.split("/")
        states.setdefault(name, {}).setdefault(int(seed), {})[key] = value
    found: dict[str, list[Learned]] = {}
    for name, seeds in states.items():
        found[name] = []
        for seed in sorted(seeds):
            network = Learned((), on_rule=False)
            network.load_state_dict(seeds[seed])
            found[name].append(network)
    return found
