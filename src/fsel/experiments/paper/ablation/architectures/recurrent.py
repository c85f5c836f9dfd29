"""Scorers that read a sequence: of the picks, or of the candidates in capture order."""

from __future__ import annotations

import torch
from torch import nn

from fsel.experiments.paper.ablation.architectures.attention import encoder
from fsel.experiments.paper.ablation.architectures.steps import Steps
from fsel.features.columns import INPUTS
from fsel.selectors.scorer import WIDTH
from fsel.training.imitation import perceptron

CELLS = {"lstm": nn.LSTM, "gru": nn.GRU, "rnn": nn.RNN}
SPAN = 5  # frames that a convolution sees at once
DILATIONS = (1, 2, 4)


class Sequential(nn.Module):
    """A recurrent state of the picks so far, beside each candidate."""

    def __init__(self, cell: str, hidden: int) -> None:
        super().__init__()
        self.memory = CELLS[cell](INPUTS, hidden)
        self.head = perceptron(WIDTH, inputs=INPUTS + hidden)

    def forward(self, steps: Steps) -> torch.Tensor:
        state, _ = self.memory(steps.before(steps.features))
        state = state[:, None].expand(-1, steps.features.shape[1], -1)
        return self.head(torch.cat([steps.features, state], dim=-1)).squeeze(-1)


class Decoder(nn.Module):
    """Candidates encoded once by self-attention; an LSTM reads the encodings of the picks."""

    def __init__(self) -> None:
        super().__init__()
        self.embedding = nn.Linear(INPUTS, WIDTH)
        self.encoder = encoder(1)
        self.memory = nn.LSTM(WIDTH, WIDTH)
        self.head = perceptron(WIDTH, inputs=INPUTS + 2 * WIDTH)

    def forward(self, steps: Steps) -> torch.Tensor:
        encoded = self.encoder(self.embedding(steps.features[:1]))
        encoded = encoded.expand(len(steps.picks), -1, -1)
        state, _ = self.memory(steps.before(encoded))
        state = state[:, None].expand_as(encoded)
        return self.head(torch.cat([steps.features, encoded, state], dim=-1)).squeeze(-1)


class Bidirectional(nn.Module):
    """An LSTM over the candidates in capture order, both ways, at every step anew."""

    def __init__(self) -> None:
        super().__init__()
        self.memory = nn.LSTM(INPUTS, WIDTH // 2, batch_first=True, bidirectional=True)
        self.head = nn.Linear(WIDTH, 1)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden, _ = self.memory(steps.features)
        return self.head(hidden).squeeze(-1)


class Convolution(nn.Module):
    """Convolutions along capture order, ever wider apart."""

    def __init__(self) -> None:
        super().__init__()
        widths = [INPUTS, *[WIDTH] * len(DILATIONS)]
        parts = []
        for i, dilation in enumerate(DILATIONS):
            parts += [
                nn.Conv1d(widths[i], widths[i + 1], SPAN, padding="same", dilation=dilation),
                nn.GELU(),
            ]
        self.layers = nn.Sequential(*parts, nn.Conv1d(WIDTH, 1, 1))

    def forward(self, steps: Steps) -> torch.Tensor:
        return self.layers(steps.features.transpose(1, 2)).squeeze(1)
