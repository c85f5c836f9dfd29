"""Compiled passes over many rays: the loss with its gradient, images, and which cells are seen."""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.reconstruct.radiance_field.rays import (
    HALF_SIDE,
    OPAQUE,
    backpropagate,
    composite,
    harmonics,
    optical_depth,
    sample,
    trilinear,
    width_of,
)

MIDDLE = 0.5  # share of a step before the first sample, where it is not drawn


def record(rays, step, count, kind):
    """Make room for what is kept of the samples of some rays: contracted space less than doubles
    the length of one. `kind` is an array of their type; pages that are not written take no memory.
    """
    room, dtype = rays * _longest(step), kind.dtype
    rows, shares = np.empty((room, 8), np.int32), np.empty((room, 8), dtype)
    return rows, shares, np.empty((room, width_of(count)), dtype), np.empty(room)


@exact_part
def _buffers(step, count, dtype):
    room = _longest(step)
    samples = np.empty(room, np.int64), np.empty((room, 3), dtype)
    return samples, np.empty((room, 6), dtype), np.empty(count, dtype)


@exact
def _longest(step):
    return int(4.0 * math.sqrt(3.0) * HALF_SIDE / step) + 2


@exact
def loss_and_gradient(rays, truth, late, near, grid, field, count, background, least, total, kept):
    """Return (n,) squared errors of rays, summed over channels, and (n + 1,) ends of their samples;
    keep the gradient of the sum over `total` in a `record` of n rays, for `add_up`.

    Of (n, 6) rays, (n, 3) colours, and (n,) shares of a step before the first sample; `grid` and
    `field` are those of `sample` and `composite`, `count` the harmonics.
    """
    step, side, occupied = grid
    (cells, parts), state, basis = _buffers(step, count, truth.dtype)
    out, slope = np.empty_like(truth[0]), np.empty_like(truth[0])
    errors, ends = np.zeros(len(rays)), np.zeros(len(rays) + 1, np.int64)
    for q in range(len(rays)):
        harmonics(rays[q], basis)
        met = sample(rays[q], near, np.float64(late[q]), step, side, occupied, cells, parts)
        samples, at = (cells[:met], parts[:met]), ends[q]
        own = kept[0][at:], kept[1][at:], kept[2][at:], kept[3][at:]
        n, left = composite(samples, side, step, field, basis, least, own, state, out)
        behind = 0.0
        for channel in range(3):
            error = out[channel] + left * background[channel] - truth[q, channel]
            errors[q] += error * error
            slope[channel] = 2.0 * error / total
            behind += slope[channel] * left * background[channel]
        backpropagate(n, own, state, basis, slope, behind)
        ends[q + 1] = at + n
    return errors, ends


def render_rays(rays, near, grid, field, count, background, least, out):
    """Fill (n, 3) colours of rays, with samples in the middle of their steps."""
    kept = record(1, grid[0], count, out)
    _render(rays, near, grid, field, count, background, least, kept, out)


@exact
def _render(rays, near, grid, field, count, background, least, kept, out):
    step, side, occupied = grid
    (cells, parts), state, basis = _buffers(step, count, out.dtype)
    for q in range(len(rays)):
        harmonics(rays[q], basis)
        met = sample(rays[q], near, MIDDLE, step, side, occupied, cells, parts)
        samples = cells[:met], parts[:met]
        _, left = composite(samples, side, step, field, basis, least, kept, state, out[q])
        for channel in range(3):
            out[q, channel] += left * background[channel]


@exact
def largest_weights(rays, near, grid, field):
    """Return (side**3,) largest weights of each cell's samples in the colour of any ray."""
    step, side, occupied = grid
    index, density, _ = field
    (cells, parts), _, _ = _buffers(step, 1, density.dtype)
    rows, shares = np.empty(8, np.int32), np.empty(8, density.dtype)
    seen = np.zeros(len(occupied), density.dtype)
    for q in range(len(rays)):
        met = sample(rays[q], near, MIDDLE, step, side, occupied, cells, parts)
        left = 1.0
        for s in range(met):
            trilinear(cells[s], parts[s], side, index, rows, shares)
            weight = left * (1.0 - math.exp(-optical_depth(rows, shares, density, step)))
            seen[cells[s]] = max(seen[cells[s]], weight)
            left -= weight
            if left < OPAQUE:
                break
    return seen
