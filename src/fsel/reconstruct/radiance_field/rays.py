"""Compiled work on one ray: its samples, the colour they add up to, and the gradient of it.

All of space is contracted into the cube of half-side 2: a point at largest coordinate r > 1 moves
to 2 - 1/r along its direction from the middle (Barron et al. 2022, with that norm).
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.reconstruct.lanes import LANES, blend, scatter

HALF_SIDE = 2.0  # of the cube that all of space is contracted into
MARGIN = 0.25  # cells before the wall of the cube, at which a ray ends: the wall is at infinity
OPAQUE = 1e-4  # transmittance at which a ray ends
DENSEST = 15.0  # logarithm of the largest density: no exponential overflows


@exact
def shrink(r):
    """Return the factor by which a point at largest coordinate r moves towards the middle."""
    if r <= 1.0:
        return 1.0
    inverse = 1.0 / r
    return (2.0 - inverse) * inverse


@exact
def pace(x, y, z, dx, dy, dz):
    """Return the contracted length that a ray passes at a point for each unit of its own."""
    ax, ay, az = abs(x), abs(y), abs(z)
    r = max(ax, ay, az)
    if r <= 1.0:
        return 1.0
    if ax == r:
        outward, a, da, b, db = math.copysign(dx, dx * x), y, dy, z, dz
    elif ay == r:
        outward, a, da, b, db = math.copysign(dy, dy * y), x, dx, z, dz
    else:
        outward, a, da, b, db = math.copysign(dz, dz * z), x, dx, y, dy
    inverse = 1.0 / r
    factor = (2.0 - inverse) * inverse
    change = 2.0 * (inverse - 1.0) * inverse * inverse * outward
    u, v = da * factor + a * change, db * factor + b * change
    along = outward * inverse * inverse
    return math.sqrt(along * along + u * u + v * v)


@exact
def sample(ray, near, late, step, side, occupied, cells, parts):
    """Fill the (S,) cells and (S, 3) places in them, 0..1, of a ray's samples in occupied cells,
    by the lowest vertex of `side` along an edge, at equal contracted steps; return their number.

    The (6,) ray, origin and unit direction, starts at distance `near` and a share `late` of a step.
    """
    scale = (side - 1) / (2.0 * HALF_SIDE)
    wall = HALF_SIDE - MARGIN / scale
    dx, dy, dz = float(ray[3]), float(ray[4]), float(ray[5])
    x, y, z = ray[0] + near * dx, ray[1] + near * dy, ray[2] + near * dz
    ahead, count = late * step, 0
    while count < len(cells):
        t = ahead / pace(x, y, z, dx, dy, dz)
        x, y, z = x + t * dx, y + t * dy, z + t * dz
        ahead = step
        r = max(abs(x), abs(y), abs(z))
        factor = shrink(r)
        if not r * factor < wall:
            break
        u = (x * factor + HALF_SIDE) * scale
        v = (y * factor + HALF_SIDE) * scale
        w = (z * factor + HALF_SIDE) * scale
        i, j, k = int(u), int(v), int(w)
        cell = (i * side + j) * side + k
        if occupied[cell]:
            cells[count] = cell
            parts[count, 0], parts[count, 1], parts[count, 2] = u - i, v - j, w - k
            count += 1
    return count


@exact_part
def trilinear(cell, part, side, index, rows, shares):
    """Fill the (8,) rows of the vertices around a sample, and their (8,) weights."""
    for c in range(8):
        a, b, d = c >> 2, (c >> 1) & 1, c & 1
        rows[c] = index[cell + (a * side + b) * side + d]
        u = part[0] if a else 1.0 - part[0]
        v = part[1] if b else 1.0 - part[1]
        w = part[2] if d else 1.0 - part[2]
        shares[c] = u * v * w


@exact_part
def optical_depth(rows, shares, density, step):
    """Return the interpolated density, whose logarithm the vertices hold, times the step."""
    raw = 0.0
    for c in range(8):
        raw += shares[c] * density[rows[c]]
    return math.exp(min(raw, DENSEST)) * step


@exact_part
def harmonics(ray, basis):
    """Fill real spherical harmonics of a direction, up to factors: 1; x, y, z; five more."""
    x, y, z = float(ray[3]), float(ray[4]), float(ray[5])
    basis[0] = 1.0
    if len(basis) > 1:
        basis[1], basis[2], basis[3] = x, y, z
    if len(basis) > 4:
        basis[4], basis[5], basis[6] = 2.0 * x * y, 2.0 * y * z, 2.0 * x * z
        basis[7], basis[8] = x * x - y * y, (3.0 * z * z - 1.0) / 2.0


@exact
def width_of(count):
    """Return the columns of `count` harmonics of three channels, padded to whole lanes."""
    return (3 * count + LANES - 1) // LANES * LANES


@exact_part
def composite(samples, side, step, field, basis, least, kept, state, out):
    """Composite one ray front to back; return the samples kept and the transmittance left.

    Of (cells, parts) of `sample`, a field of (side**3,) indices, (m,) logarithms of density and
    flat (m * W,) raw colours, and `harmonics` of the ray; samples of an optical depth below `least`
    are passed over. Fills the (S, 8) rows and shares of `kept`, a (S, 6) state of three channels,
    weight, transmittance behind and optical depth, and the (3,) colour without any background.
    """
    cells, parts = samples
    index, density, color = field
    rows, shares, lanes = kept[0], kept[1], kept[2][0]
    flat_rows, flat_shares, width = rows.reshape(-1), shares.reshape(-1), width_of(len(basis))
    left, n = 1.0, 0
    out[:] = 0
    for s in range(len(cells)):
        trilinear(cells[s], parts[s], side, index, rows[n], shares[n])
        depth = optical_depth(rows[n], shares[n], density, step)
        if depth < least:
            continue
        weight = left * (1.0 - math.exp(-depth))
        left -= weight
        for at in range(0, width, LANES):
            blend(lanes, color, flat_rows, flat_shares, n, width, at)
        _shade(lanes, basis, state[n])
        for channel in range(3):
            out[channel] += weight * state[n, channel]
        state[n, 3], state[n, 4], state[n, 5] = weight, left, depth
        n += 1
        if left < OPAQUE:
            break
    return n, left


@exact_part
def _shade(lanes, basis, channels):
    """Fill the colour seen from the basis' direction: the sigmoid of the harmonics' sum."""
    zero = basis[0] * 0
    red, green, blue = zero, zero, zero
    for h in range(len(basis)):
        red += basis[h] * lanes[3 * h]
        green += basis[h] * lanes[3 * h + 1]
        blue += basis[h] * lanes[3 * h + 2]
    channels[0] = 1.0 / (1.0 + math.exp(-red))
    channels[1] = 1.0 / (1.0 + math.exp(-green))
    channels[2] = 1.0 / (1.0 + math.exp(-blue))


@exact_part
def backpropagate(n, kept, state, basis, slope, behind):
    """Fill the gradients of a ray's samples, by raw colours (S, W) and log density (S,), of `kept`.

    With weights w, colours c and transmittances T, the colour C has the derivative by the optical
    depth of sample i: dC/dt_i = T_(i+1) c_i - (sum of w_j c_j over j > i, and the background). The
    background adds `behind` times the (3,) `slope`, the gradient of the loss by the colour.
    """
    _, _, lanes, changes = kept
    lanes[:n, 3 * len(basis) :] = 0
    for s in range(n - 1, -1, -1):
        weight, left, depth = state[s, 3], state[s, 4], state[s, 5]
        worth = 0.0
        for channel in range(3):
            shade = state[s, channel]
            worth += slope[channel] * shade
            turned = slope[channel] * weight * shade * (1.0 - shade)
            for h in range(len(basis)):
                lanes[s, 3 * h + channel] = turned * basis[h]
        changes[s] = (left * worth - behind) * depth
        behind += weight * worth


@exact
def add_up(kept, ends, gradients, first, last):
    """Add the gradients of samples, ray by ray from its end, to the vertices `first` to `last`.

    `ends` are the (n + 1,) bounds of each ray's samples in `kept`. What belongs to other vertices
    is added to the last row of the gradients of log density and of raw colours, which is flat.
    """
    rows, shares, lanes, changes = kept
    density, color = gradients
    spot, parts, width = np.empty(8, rows.dtype), np.empty(8, shares.dtype), lanes.shape[1]
    for q in range(len(ends) - 1):
        for s in range(ends[q + 1] - 1, ends[q] - 1, -1):
            if rows[s, 7] < first or rows[s, 0] >= last:  # the vertices of a sample ascend
                continue
            for c in range(8):
                row, parts[c] = rows[s, c], shares[s, c]
                spot[c] = row if first <= row < last else len(density) - 1
                density[spot[c]] += parts[c] * changes[s]
            for at in range(0, width, LANES):
                scatter(color, lanes[s], spot, parts, 0, width, at)
