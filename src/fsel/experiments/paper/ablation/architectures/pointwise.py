"""Scorers that see candidates alone, or through a pooled summary of all."""

from __future__ import annotations

import torch
from torch import nn

from fsel.experiments.paper.ablation.architectures.steps import Steps
from fsel.features.columns import INPUTS
from fsel.selectors.scorer import WIDTH
from fsel.training.imitation import perceptron


class Perceptron(nn.Module):
    """The paper's scorer, of any width."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.layers = perceptron(width)

    def forward(self, steps: Steps) -> torch.Tensor:
        return self.layers(steps.features).squeeze(-1)


class Residual(nn.Module):
    """Blocks of two layers, each added to what it was given (normalised before)."""

    def __init__(self, blocks: int) -> None:
        super().__init__()
        self.first = nn.Linear(INPUTS, WIDTH)
        self.blocks = nn.ModuleList(
            nn.Sequential(
                nn.LayerNorm(WIDTH),
                nn.Linear(WIDTH, WIDTH),
                nn.GELU(),
                nn.Linear(WIDTH, WIDTH),
            )
            for _ in range(blocks)
        )
        self.last = nn.Linear(WIDTH, 1)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden = self.first(steps.features)
        for block in self.blocks:
            hidden = hidden + block(hidden)
        return self.last(hidden).squeeze(-1)


class Pooled(nn.Module):
    """Each candidate beside the mean and the maximum over all that are selectable."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(INPUTS, WIDTH), nn.GELU())
        self.head = perceptron(WIDTH, inputs=3 * WIDTH)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden = self.encoder(steps.features)
        gone = ~steps.selectable[..., None]
        mean = hidden.masked_fill(gone, 0.0).sum(1) / steps.selectable.sum(1, keepdim=True)
        most = hidden.masked_fill(gone, -torch.inf).amax(1)
        context = torch.cat([mean, most], dim=-1)[:, None].expand(-1, hidden.shape[1], -1)
        return self.head(torch.cat([hidden, context], dim=-1)).squeeze(-1)


class Rescoring(nn.Module):
    """Scores corrected some times over, each time beside the mean under their own softmax."""

    def __init__(self, rounds: int) -> None:
        super().__init__()
        self.rounds = rounds
        self.encoder = nn.Sequential(nn.Linear(INPUTS, WIDTH), nn.GELU())
        self.first = nn.Linear(WIDTH, 1)
        self.correction = perceptron(WIDTH, inputs=2 * WIDTH + 1)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden = self.encoder(steps.features)
        scores = self.first(hidden)
        gone = ~steps.selectable[..., None]
        for _ in range(self.rounds):
            share = scores.masked_fill(gone, -torch.inf).softmax(dim=1)
            mean = (share * hidden).sum(dim=1, keepdim=True).expand_as(hidden)
            scores = scores + self.correction(torch.cat([hidden, mean, scores], dim=-1))
        return scores.squeeze(-1)
