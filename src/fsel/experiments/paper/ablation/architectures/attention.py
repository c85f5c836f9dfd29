"""Scorers that attend: to the selected frames, to one another, to the optimization views."""

from __future__ import annotations

import math

import torch
from torch import nn

from fsel.experiments.paper.ablation.architectures.steps import Steps
from fsel.features.columns import CONDITIONED, INPUTS, SHARPNESS, positions
from fsel.selectors.scorer import WIDTH
from fsel.training.imitation import perceptron

HEADS = 4
WAVELENGTHS = 10_000.0  # of the longest of the positional encoding (Vaswani et al. 2017)
OWN = positions((*CONDITIONED, SHARPNESS)).tolist()
RELATIONS = 3


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
            hidden = hidden + place_encoding(hidden.shape[1])
        hidden = self.encoder(hidden, src_key_padding_mask=~steps.selectable)
        return self.head(hidden).squeeze(-1)


class ViewAttention(nn.Module):
    """Attention over the optimization views in place of the thirteen fixed summaries of them.

    A candidate's four features that follow the selection and its sharpness are the query; its
    relations to each view are keys and values.
    """

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
    """A transformer encoder without dropout, normalised before each layer."""
    layer = nn.TransformerEncoderLayer(
        WIDTH,
        HEADS,
        dim_feedforward=2 * WIDTH,
        dropout=0.0,
        activation="gelu",
        batch_first=True,
        norm_first=True,
    )
    return nn.TransformerEncoder(layer, layers, enable_nested_tensor=False)


def place_encoding(count: int) -> torch.Tensor:
    """(count, 64) sinusoidal encoding of the place in capture order (Vaswani et al. 2017)."""
    rate = torch.exp(-math.log(WAVELENGTHS) * torch.arange(0, WIDTH, 2) / WIDTH)
    angle = torch.arange(count)[:, None] * rate
    return torch.stack([angle.sin(), angle.cos()], dim=-1).flatten(1)
