"""Optimisation of the field, coarse to fine."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact
from fsel.reconstruct.radiance_field import passes
from fsel.reconstruct.radiance_field.grid import Grid, grown
from fsel.reconstruct.radiance_field.settings import RadianceSettings

EMPTY = -1.0  # logarithm of density that the field starts from: a ray sees half-way through it
FAINT = 1e-3  # optical depth below which a sample is passed over, once the first stage is done
DECAY = 0.1  # of the step size, from the first step to the last
BENDS = 1.0, 0.1  # differences of density and of colour from which variation counts linearly
BETAS = (0.9, 0.99)
TINY = 1e-10  # beside the root of the second moment

Progress = Callable[[int, int, float], None]


class Pixels(NamedTuple):
    """Pixels that the field must explain."""

    rays: np.ndarray  # (n, 6) float32 origins and unit directions, in the field's coordinates
    truth: np.ndarray  # (n, 3) float32 colours in [0, 1]
    near: float  # where rays start
    background: np.ndarray  # (3,) float32 colour behind everything


def optimised(pixels: Pixels, settings: RadianceSettings, progress: Progress | None) -> Grid:
    """Optimise the field through all stages; see `RadianceField.fit` for `progress`."""
    color = np.clip(pixels.background, 0.02, 0.98)
    harmonics = (settings.degree + 1) ** 2
    grid = Grid.full(settings.sides[0], EMPTY, np.log(color / (1 - color)), harmonics)
    if not len(pixels.rays):  # no cells, which shows the background alone
        return grid.refined(np.zeros_like(grid.cells), grid.side, EMPTY)
    rng = np.random.default_rng(settings.seed)
    made, total = 0, sum(settings.steps)
    for stage, steps in enumerate(settings.steps):
        if stage:
            share = np.empty(len(grid.occupied), np.float32)
            passes.largest_weights(pixels.rays, pixels.near, grid.shape, grid.field, share)
            kept = grown((share > settings.visible).reshape(grid.cells.shape))
            grid = grid.refined(kept, settings.sides[stage], EMPTY)
        optimiser = _Optimiser(grid, pixels, settings, FAINT if stage else 0.0)
        draws = _draws(rng, len(pixels.rays), settings.rays)
        for turn in range(1, steps + 1):
            loss = optimiser.step(next(draws), rng, turn, DECAY ** (made / total))
            made += 1
            if progress is not None:
                progress(made, total, loss)
    return grid


def _draws(rng: np.random.Generator, count: int, size: int) -> Iterator[np.ndarray]:
    """Yield ascending rows of rays; all come before any comes again."""
    while True:
        order = rng.permutation(count)
        for start in range(0, max(count - size, 0) + 1, size):
            yield np.sort(order[start : start + size])


class _Optimiser:
    """Adam on one grid's arrays, which it changes in place."""

    def __init__(
        self, grid: Grid, pixels: Pixels, settings: RadianceSettings, least: float
    ) -> None:
        self.grid, self.pixels, self.settings, self.least = grid, pixels, settings, least
        self.rows = grid.neighbours()
        self.values = grid.density[:, None], grid.color
        self.gradients = tuple(np.zeros_like(v) for v in self.values)
        self.moments = tuple(
            (np.zeros(v.size, v.dtype), np.zeros(v.size, v.dtype)) for v in self.values
        )
        self.rates = settings.density_rate, settings.color_rate
        self.weights = settings.density_variation, settings.color_variation

    def step(self, drawn: np.ndarray, rng: np.random.Generator, turn: int, decay: float) -> float:
        """Make one step on the drawn rays; return the loss without its variation."""
        pixels, grid = self.pixels, self.grid
        late = 1 - rng.random(len(drawn), dtype=np.float32)
        flat = tuple(g.reshape(-1) for g in self.gradients)
        given = pixels.rays[drawn], pixels.truth[drawn], late, pixels.near
        field = grid.shape, grid.field, grid.harmonics, pixels.background
        loss = passes.loss_and_gradient(*given, *field, self.least, flat)
        for part, values in enumerate(self.values):
            if self.weights[part] > 0:
                weight = np.float32(self.weights[part] / max(len(values), 1))
                bend = np.float32(BENDS[part])
                add_variation(self.rows, values, weight, bend, self.gradients[part])
            rate = self.rates[part] * decay
            adam_step(values.reshape(-1), flat[part], self.moments[part], rate, turn)
        return loss


@exact
def add_variation(rows, values, weight, bend, gradient):
    """Add the gradient of Huber's norm, linear beyond `bend`, of differences of (n, m) values at
    (n, 3) int32 `Grid.neighbours`, summed and weighted."""
    for n in range(len(rows)):
        for axis in range(3):
            other = rows[n, axis]
            if other < 0:
                continue
            for m in range(values.shape[1]):
                gap = (values[other, m] - values[n, m]) / bend
                push = weight * min(max(gap, -1.0), 1.0)
                gradient[other, m] += push
                gradient[n, m] -= push


@exact
def adam_step(values, gradient, moments, rate, turn):
    """Make step `turn` of Adam (Kingma and Ba 2015), from 1, and clear the flat gradient; numbers
    whose gradient is zero rest."""
    first, second = moments
    one, two = BETAS
    scale, root = rate / (1.0 - one**turn), 1.0 / (1.0 - two**turn)
    for n in range(len(values)):
        slope = gradient[n]
        if slope != 0:
            gradient[n] = 0
            first[n] = one * first[n] + (1.0 - one) * slope
            second[n] = two * second[n] + (1.0 - two) * slope * slope
            values[n] -= scale * first[n] / (math.sqrt(second[n] * root) + TINY)
