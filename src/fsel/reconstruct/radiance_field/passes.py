"""Compiled passes over many rays: the loss with its gradient, images, and which cells are seen."""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact
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


@exact
def _buffers(step, count, dtype):
    """Make buffers for the longest ray, whose length contracted space less than doubles."""
    room = int(4.0 * math.sqrt(3.0) * HALF_SIDE / step) + 2
    samples = np.empty(room, np.int64), np.empty((room, 3), dtype)
    kept = (
        np.empty((room, 8), np.int32),
        np.empty((room, 8), dtype),
        np.empty((room, 6), dtype),
        np.empty(width_of(count), dtype),
    )
    return samples, kept, np.empty(count, dtype)


@exact
def loss_and_gradient(rays, truth, late, near, grid, field, count, background, least, gradients):
    """Return the squared error of rays, summed over channels, mean over rays; add its gradient.

    Args:
        rays: (n, 6) origins and unit directions.
        truth: (n, 3) colours.
        late: (n,) in (0, 1], share of a step before each ray's first sample.
        near: distance at which rays start.
        grid: step, side and occupied of `sample`.
        field, least: of `composite`.
        count: harmonics.
        background: (3,) colour.
        gradients: of `backpropagate`.
    """
    step, side, occupied = grid
    (cells, parts), kept, basis = _buffers(step, count, truth.dtype)
    out, slope = np.empty_like(truth[0]), np.empty_like(truth[0])
    loss = 0.0
    for q in range(len(rays)):
        harmonics(rays[q], basis)
        met = sample(rays[q], near, late[q], step, side, occupied, cells, parts)
        samples = cells[:met], parts[:met]
        n, left = composite(samples, side, step, field, basis, least, kept, out)
        behind = 0.0
        for channel in range(3):
            error = out[channel] + left * background[channel] - truth[q, channel]
            loss += error * error
            slope[channel] = 2.0 * error / len(rays)
            behind += slope[channel] * left * background[channel]
        backpropagate(n, kept, basis, slope, behind, gradients)
    return loss / len(rays)


@exact
def render_rays(rays, near, grid, field, count, background, least, out):
    """Fill (n, 3) colours of rays, with samples in the middle of their steps."""
    step, side, occupied = grid
    (cells, parts), kept, basis = _buffers(step, count, out.dtype)
    for q in range(len(rays)):
        harmonics(rays[q], basis)
        met = sample(rays[q], near, MIDDLE, step, side, occupied, cells, parts)
        samples = cells[:met], parts[:met]
        _, left = composite(samples, side, step, field, basis, least, kept, out[q])
        for channel in range(3):
            out[q, channel] += left * background[channel]


@exact
def largest_weights(rays, near, grid, field, seen):
    """Fill (side**3,) largest weights of each cell's samples in the colour of any ray."""
    step, side, occupied = grid
    index, density, _ = field
    (cells, parts), kept, _ = _buffers(step, 1, density.dtype)
    rows, shares = kept[0][0], kept[1][0]
    seen[:] = 0
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
