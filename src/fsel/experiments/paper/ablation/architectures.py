"""Scorers that the paper compared its own with (Appendix D.1), one class each.

The paper names them; details are ours. `config/scorers.yaml` says which settings make which row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import nn

from fsel.features.columns import CONDITIONED, INPUTS, SHARPNESS, positions
from fsel.selectors.scorer import WIDTH
from fsel.training.imitation import perceptron

CELLS = {"lstm": nn.LSTM, "gru": nn.GRU, "rnn": nn.RNN}
SPAN = 5  # frames that a convolution sees at once
DILATIONS = (1, 2, 4)
HEADS = 4
WAVELENGTHS = 10_000.0  # of the longest of the positional encoding
OWN = positions((*CONDITIONED, SHARPNESS)).tolist()
RELATIONS = 3


@dataclass(frozen=True)
class Steps:
    """K steps over a pool of n frames, in capture order, which a scorer maps to (K, n) scores.

    Scores of step t may depend on the picks of the steps before t, never on later ones.

    Attributes:
        features: (K, n, 19) float32 standardised inputs.
        selectable: (K, n) bool, False once a row is picked; no scorer need mask its own scores.
        picks: (K,) int64 row picked at each step.
        views: (n, O, 3) float32 standardised distance, angle and likeness to each proxy.
    """

    features: torch.Tensor
    selectable: torch.Tensor
    picks: torch.Tensor
    views: torch.Tensor

    def before(self, values: torch.Tensor) -> torch.Tensor:
        """(K, ...) `values` (K, n, ...) of the pick one step before; zero at the first."""
        taken = values[torch.arange(len(self.picks)), self.picks]
        return torch.cat([torch.zeros_like(taken[:1]), taken[:-1]])


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
                nn.LayerNorm(WIDTH), nn.Linear(WIDTH, WIDTH), nn.GELU(), nn.Linear(WIDTH, WIDTH)
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


class CrossAttention(nn.Module):
    """Each candidate attends to the frames selected so far, and to a learned start."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(INPUTS, WIDTH), nn.GELU())
        self.start = nn.Parameter(torch.zeros(1, WIDTH))
        self.attention = nn.MultiheadAttention(WIDTH, HEADS, batch_first=True)
        self.head = perceptron(WIDTH, inputs=2 * WIDTH)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden = self.encoder(steps.features)
        count, rows, _ = hidden.shape
        keys = torch.cat([self.start, steps.before(hidden)[1:]])[None]
        step = torch.arange(count)
        later = (step[None] > step[:, None]).repeat_interleave(rows, dim=0)
        queries = hidden.reshape(1, -1, WIDTH)
        seen, _ = self.attention(queries, keys, keys, attn_mask=later, need_weights=False)
        both = torch.cat([hidden, seen.reshape(hidden.shape)], dim=-1)
        return self.head(both).squeeze(-1)


class SelfAttention(nn.Module):
    """A transformer encoder over the selectable candidates, a set unless `order` is given."""

    def __init__(self, layers: int, order: bool) -> None:
        super().__init__()
        self.order = order
        self.embedding = nn.Linear(INPUTS, WIDTH)
        self.encoder = encoder(layers)
        self.head = nn.Linear(WIDTH, 1)

    def forward(self, steps: Steps) -> torch.Tensor:
        hidden = self.embedding(steps.features)
        if self.order:
            # sinusoidal encoding of the place in capture order (Vaswani et al. 2017)
            rate = torch.exp(-math.log(WAVELENGTHS) * torch.arange(0, WIDTH, 2) / WIDTH)
            angle = torch.arange(hidden.shape[1])[:, None] * rate
            hidden = hidden + torch.stack([angle.sin(), angle.cos()], dim=-1).flatten(1)
        hidden = self.encoder(hidden, src_key_padding_mask=~steps.selectable)
        return self.head(hidden).squeeze(-1)


class ViewAttention(nn.Module):
    """Attention over the optimization views, queried by a candidate's five other features."""

    def __init__(self) -> None:
        super().__init__()
        self.query = nn.Linear(len(OWN), WIDTH)
        self.views = nn.Sequential(nn.Linear(RELATIONS, WIDTH), nn.GELU())
        self.attention = nn.MultiheadAttention(WIDTH, HEADS, batch_first=True)
        self.head = perceptron(WIDTH, inputs=WIDTH + len(OWN))

    def forward(self, steps: Steps) -> torch.Tensor:
        own = steps.features[..., OWN]
        views = self.views(steps.views)
        queries = self.query(own).transpose(0, 1)
        seen, _ = self.attention(queries, views, views, need_weights=False)
        return self.head(torch.cat([seen.transpose(0, 1), own], dim=-1)).squeeze(-1)


def encoder(layers: int) -> nn.TransformerEncoder:
    """Build a transformer encoder without dropout, normalised before each layer."""
    layer = nn.TransformerEncoderLayer(
        WIDTH, HEADS, 2 * WIDTH, dropout=0.0, activation="gelu", batch_first=True, norm_first=True
    )
    return nn.TransformerEncoder(layer, layers, enable_nested_tensor=False)


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
        for (given, made), dilation in zip(pairwise(widths), DILATIONS, strict=True):
            layer = nn.Conv1d(given, made, SPAN, padding="same", dilation=dilation)
            parts += [layer, nn.GELU()]
        self.layers = nn.Sequential(*parts, nn.Conv1d(WIDTH, 1, 1))

    def forward(self, steps: Steps) -> torch.Tensor:
        return self.layers(steps.features.transpose(1, 2)).squeeze(1)


MODULES = {
    "perceptron": Perceptron,
    "residual": Residual,
    "pooled": Pooled,
    "rescoring": Rescoring,
    "cross_attention": CrossAttention,
    "self_attention": SelfAttention,
    "view_attention": ViewAttention,
    "decoder": Decoder,
    "sequential": Sequential,
    "bilstm": Bidirectional,
    "convolution": Convolution,
}
