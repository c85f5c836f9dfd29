"""Optimisation of the field, coarse to fine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact
from fsel.core.threads import ranges, spread
from fsel.reconstruct.configured import check_integer
from fsel.reconstruct.radiance_field import passes, rays
from fsel.reconstruct.radiance_field.grid import FEWEST, Grid, grown

EMPTY = -1.0  # logarithm of density that the field starts from: a ray sees half-way through it
FAINT = 1e-3  # optical depth below which a sample is passed over, once the first stage is done
VISIBLE = 0.05  # least share of any selected pixel that a cell must give to be refined
# of density and of colour: first step sizes of Adam, and weights of the total variation, a mean
# over vertices, beside the squared error, a mean over rays
RATES, VARIATIONS = (1.0, 0.4), (0.01, 0.01)
DECAY = 0.1  # of the step size, from the first step to the last
BENDS = 1.0, 0.1  # differences of density and of colour from which variation counts linearly
BETAS = (0.9, 0.99)
TINY = 1e-10  # beside the root of the second moment
FEWEST_RAYS, BLOCK = 128, 4096  # of a range; rays whose samples are kept at once
THINNED = 64  # one sample of so many says where the ranges of vertices are cut

HIGHEST_DEGREE = 2
FINEST = 512  # vertices along an edge: the index of their cube takes 512 MB


@dataclass(frozen=True)
class RadianceSettings:
    """Settings of the optimisation; all are free of the scene.

    Attributes:
        sides: vertices along an edge of the contracted cube, one number a stage, coarse to fine.
        steps: of Adam, one number a stage.
        rays: pixels drawn for one step.
        degree: of the spherical harmonics of colour, 0 to 2.
        seed: of the order of the rays and the places of their samples.
    """

    sides: tuple[int, ...] = (40, 80, 144)
    steps: tuple[int, ...] = (80, 80, 100)
    rays: int = 4096
    degree: int = 1
    seed: int = 0

    def __post_init__(self) -> None:
        for name, least, most in (("sides", 4, FINEST), ("steps", 1, math.inf)):
            if not isinstance(listed := getattr(self, name), list | tuple):
                raise ValueError(f"{name} must be a list of integers, got {listed!r}")
            for value in listed:
                check_integer(f"each of {name}", value, least, most)
            object.__setattr__(self, name, tuple(listed))
        if not len(self.sides) == len(self.steps) > 0:
            raise ValueError(
                f"sides and steps must state as many stages, got {self.sides} and {self.steps}"
            )
        if not all(a < b for a, b in pairwise(self.sides)):
            raise ValueError(f"sides must rise, got {self.sides}")
        for name, most in {"rays": math.inf, "degree": HIGHEST_DEGREE, "seed": math.inf}.items():
            check_integer(name, getattr(self, name), int(name == "rays"), most)


class Pixels(NamedTuple):
    """Pixels that the field must explain."""

    rays: np.ndarray  # (n, 6) float32 origins and unit directions, in the field's coordinates
    truth: np.ndarray  # (n, 3) float32 colours in [0, 1]
    near: float  # where rays start
    background: np.ndarray  # (3,) float32 colour behind everything


def optimised(pixels: Pixels, settings: RadianceSettings) -> Grid:
    """Optimise the field through all stages."""
    color = np.clip(pixels.background, 0.02, 0.98)
    harmonics = (settings.degree + 1) ** 2
    grid = Grid.full(settings.sides[0], EMPTY, np.log(color / (1 - color)), harmonics)
    if not len(pixels.rays):  # no cells, which shows the background alone
        return grid.refined(np.zeros_like(grid.cells), grid.side, EMPTY)
    rng = np.random.default_rng(settings.seed)
    made, total = 0, sum(settings.steps)
    for stage, steps in enumerate(settings.steps):
        if stage:
            share = _largest_weights(pixels, grid)
            kept = grown((share > VISIBLE).reshape(grid.cells.shape))
            grid = grid.refined(kept, settings.sides[stage], EMPTY)
        optimiser = _Optimiser(grid, pixels, FAINT if stage else 0.0)
        draws = _draws(rng, len(pixels.rays), settings.rays)
        for turn in range(1, steps + 1):
            optimiser.step(next(draws), rng, turn, DECAY ** (made / total))
            made += 1
    return grid


def _largest_weights(pixels: Pixels, grid: Grid) -> np.ndarray:
    """Return (side**3,) of `passes.largest_weights` for all pixels."""

    def largest(first: int, last: int) -> np.ndarray:
        own = pixels.rays[first:last], pixels.near
        return passes.largest_weights(*own, grid.shape, grid.field)

    return np.maximum.reduce(spread(largest, ranges(len(pixels.rays), FEWEST, 1)))


def _draws(rng: np.random.Generator, count: int, size: int) -> Iterator[np.ndarray]:
    """Yield ascending rows of rays; all come before any comes again."""
    while True:
        order = rng.permutation(count)
        for start in range(0, max(count - size, 0) + 1, size):
            yield np.sort(order[start : start + size])


class _Part(NamedTuple):
    """One of the grid's two arrays, and what Adam needs for it."""

    values: np.ndarray  # (n, m)
    gradient: np.ndarray  # (n + 1, m), see `add_variation`
    moments: tuple[np.ndarray, np.ndarray]  # (n, m) each
    rate: float
    weight: np.float32  # of the variation of two neighbours
    bend: np.float32


class _Optimiser:
    """Adam on one grid's arrays, which it changes in place."""

    def __init__(self, grid: Grid, pixels: Pixels, least: float) -> None:
        self.grid, self.pixels, self.least = grid, pixels, least
        self.rows = grid.neighbours()
        self.reach = int((self.rows - np.arange(len(self.rows))[:, None]).max(initial=0))
        self.records: dict[tuple[int, int], tuple[np.ndarray, ...]] = {}
        self.parts = []
        arrays = grid.density[:, None], grid.color
        for values, rate, variation, bend in zip(arrays, RATES, VARIATIONS, BENDS, strict=True):
            gradient = np.zeros((len(values) + 1, values.shape[1]), values.dtype)
            moments = np.zeros_like(values), np.zeros_like(values)
            weight = np.float32(variation / max(len(values), 1))
            self.parts.append(_Part(values, gradient, moments, rate, weight, np.float32(bend)))
        self.gradients = tuple(part.gradient.reshape(-1) for part in self.parts)

    def step(self, drawn: np.ndarray, rng: np.random.Generator, turn: int, decay: float) -> float:
        """Make one step on the drawn rays; return the loss without its variation."""
        late, errors = 1 - rng.random(len(drawn), dtype=np.float32), []
        vertices = ranges(len(self.rows), FEWEST)
        for at in range(0, len(drawn), BLOCK):
            block = drawn[at : at + BLOCK], late[at : at + BLOCK], len(drawn)
            traced = spread(partial(self._trace, *block), ranges(len(block[0]), FEWEST_RAYS))
            spread(partial(self._add_up, traced), self._shared(traced))
            errors += [error for _, error, _ in traced]
        spread(self._vary, vertices)
        spread(partial(self._descend, turn, decay), vertices)
        return float(np.concatenate(errors).sum() / len(drawn))

    def _trace(self, drawn: np.ndarray, late: np.ndarray, total: int, first: int, last: int):
        """Return the record of a range of rays, their errors, and the ends of their samples."""
        grid, pixels, own = self.grid, self.pixels, drawn[first:last]
        if (first, last) not in self.records:
            room = last - first, grid.shape[0], grid.harmonics, pixels.truth
            self.records[first, last] = passes.record(*room)
        given = pixels.rays[own], pixels.truth[own], late[first:last], pixels.near
        field = grid.shape, grid.field, grid.harmonics, pixels.background, self.least
        record = self.records[first, last]
        return record, *passes.loss_and_gradient(*given, *field, total, record)

    def _shared(self, traced) -> list[tuple[int, int]]:
        """Return a range of vertices for every thread, with about as many samples each."""
        even = ranges(len(self.rows), FEWEST, 1)
        lowest = [record[0][: ends[-1] : THINNED, 0] for record, _, ends in traced]
        if len(even) == 1 or not any(map(len, lowest)):
            return even
        within = np.quantile(np.concatenate(lowest), np.arange(1, len(even)) / len(even))
        return list(pairwise([0, *within.astype(int).tolist(), len(self.rows)]))

    def _add_up(self, traced, first: int, last: int) -> None:
        for record, _, ends in traced:
            rays.add_up(record, ends, self.gradients, first, last)

    def _vary(self, first: int, last: int) -> None:
        for part in self.parts:
            given = part.values, part.weight, part.bend, part.gradient
            add_variation(self.rows, *given, self.reach, first, last)

    def _descend(self, turn: int, decay: float, first: int, last: int) -> None:
        for part in self.parts:
            arrays = (part.values, part.gradient, *part.moments)
            values, gradient, *moments = (array[first:last].reshape(-1) for array in arrays)
            adam_step(values, gradient, tuple(moments), part.rate * decay, turn)


@exact
def add_variation(rows, values, weight, bend, gradient, reach, first, last):
    """Add the gradient of Huber's norm, linear beyond `bend`, of differences of (n, m) values at
    (n, 3) int32 `Grid.neighbours`, summed and weighted, to the vertices `first` to `last`.

    Rows of neighbours are `reach` apart at most; what belongs to other vertices is added to the
    last row of the (n + 1, m) gradient.
    """
    beyond = len(gradient) - 1
    for n in range(max(first - reach, 0), last):
        for axis in range(3):
            other = rows[n, axis]
            if other < 0 or (n < first and not first <= other < last):
                continue
            own, theirs = (n if n >= first else beyond), (other if other < last else beyond)
            for m in range(values.shape[1]):
                gap = (values[other, m] - values[n, m]) / bend
                push = weight * min(max(gap, -1.0), 1.0)
                gradient[theirs, m] += push
                gradient[own, m] -= push


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
