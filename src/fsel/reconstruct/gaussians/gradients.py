"""Gradients of the projected Gaussians with respect to their parameters.

The geometry goes through blocks of Gaussians, whose loops compile to vector instructions.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import inlined, reordered, reordered_part
from fsel.reconstruct.gaussians.parameters import COLOR, LOGIT, basis, slope
from fsel.reconstruct.gaussians.projection import (
    RED,
    XX,
    XY,
    YY,
    direction,
    flattened,
    rotation,
    seen,
    tilts,
)

LANES = 32  # Gaussians of a block
# numbers of a Gaussian in a block: position in the camera's axes, quaternion, standard deviations,
# inverse covariance, sums over its pixels; then the gradients of position, scale and quaternion
POINT, TURN, SIZE, INVERSE, SUMS, MEAN_OUT, SCALE_OUT, TURN_OUT = 0, 3, 7, 10, 13, 18, 21, 24
FIELDS = 28


@reordered
def backward(table, degree, lens, rows, rank, source, sums, grad):
    """Add the gradients of the projected Gaussians to those of the parameters.

    Args:
        table, degree, lens: as in `projection.project`.
        rows: (v, COLUMNS) projected Gaussians, nearest first.
        rank, source: (m,) int32 where each is in `rows` and in `table`, in the table's order: all
            of them or a part.
        sums: (v, 9) as `rasterize.backward` fills them: gradients with respect to the colour;
            sums over the pixels of the gradient g with respect to the exponent, and of g dx, g dy,
            g dx dx, g dx dy, g dy dy, with dx and dy from the Gaussian to the pixel.
        grad: like `table`, added to.
    """
    _shade_back(table, degree, lens, rows, rank, source, sums, grad)
    block = np.ones(FIELDS * LANES)
    for start in range(0, len(source), LANES):
        count = min(LANES, len(source) - start)
        _gather(table, lens, rows, rank, source, sums, block, start, count)
        _differentiate(block, lens)
        _scatter(block, source, grad, start, count)


@reordered_part
def _gather(table, lens, rows, rank, source, sums, block, start, count):
    for p in range(count):
        n, i = rank[start + p], source[start + p]
        x, y, z = seen((float(table[i, 0]), float(table[i, 1]), float(table[i, 2])), lens)
        block[p], block[LANES + p], block[2 * LANES + p] = x, y, z
        for k in range(4):
            block[(TURN + k) * LANES + p] = table[i, 6 + k]
        for k in range(3):
            block[(SIZE + k) * LANES + p] = math.exp(table[i, 3 + k])
        block[INVERSE * LANES + p] = -2.0 * rows[n, XX]
        block[(INVERSE + 1) * LANES + p] = -1.0 * rows[n, XY]
        block[(INVERSE + 2) * LANES + p] = -2.0 * rows[n, YY]
        for k in range(5):
            block[(SUMS + k) * LANES + p] = sums[n, 4 + k]


@reordered_part
def _scatter(block, source, grad, start, count):
    for p in range(count):
        i = source[start + p]
        for k in range(3):
            grad[i, k] += block[(MEAN_OUT + k) * LANES + p]
        for k in range(7):
            grad[i, 3 + k] += block[(SCALE_OUT + k) * LANES + p]


@reordered_part
def _differentiate(block, lens):
    """Fill the gradients of a block from its other numbers."""
    for o in range(LANES):
        x, y, z = block[o], block[LANES + o], block[2 * LANES + o]
        turn = (
            block[TURN * LANES + o], block[(TURN + 1) * LANES + o],
            block[(TURN + 2) * LANES + o], block[(TURN + 3) * LANES + o],
        )  # fmt: skip
        at = SIZE * LANES + o
        s = block[at], block[at + LANES], block[at + 2 * LANES]
        a, b = block[INVERSE * LANES + o], block[(INVERSE + 1) * LANES + o]
        c = block[(INVERSE + 2) * LANES + o]
        su, sv = block[SUMS * LANES + o], block[(SUMS + 1) * LANES + o]
        uu, uv = block[(SUMS + 2) * LANES + o], block[(SUMS + 3) * LANES + o]
        vv = block[(SUMS + 4) * LANES + o]
        # gradient with respect to the covariance: half of inverse, second moments, inverse
        p, q, r, t = a * uu + b * uv, a * uv + b * vv, b * uu + c * uv, b * uv + c * vv
        back = 0.5 * (p * a + q * b), 0.5 * (p * b + q * c), 0.5 * (r * b + t * c)
        du, dv = a * su + b * sv, b * su + c * sv
        (dx, dy, dz), scale, quarter = _shape_back(lens, x, y, z, turn, s, back)
        j, k = lens[15] / z, lens[16] / z
        dx, dy, dz = dx + du * j, dy + dv * k, dz - (du * j * x + dv * k * y) / z
        at = MEAN_OUT * LANES + o
        block[at] = lens[0] * dx + lens[4] * dy + lens[8] * dz
        block[at + LANES] = lens[1] * dx + lens[5] * dy + lens[9] * dz
        block[at + 2 * LANES] = lens[2] * dx + lens[6] * dy + lens[10] * dz
        at = SCALE_OUT * LANES + o
        block[at], block[at + LANES], block[at + 2 * LANES] = scale
        at = TURN_OUT * LANES + o
        block[at], block[at + LANES], block[at + 2 * LANES], block[at + 3 * LANES] = quarter


@reordered_part
def _shade_back(table, degree, lens, rows, rank, source, sums, grad):
    """Add the gradients of opacities and harmonics, and through them of the positions."""
    values, weights = np.empty(16), np.empty(16)
    for m in range(len(source)):
        n, i = rank[m], source[m]
        grad[i, LOGIT] += sums[n, 3] / (1 + math.exp(table[i, LOGIT]))
        point = float(table[i, 0]), float(table[i, 1]), float(table[i, 2])
        x, y, z, inverse = direction(point, lens)
        basis(degree, x, y, z, values)
        # a colour below zero was cut, and does not move
        red = sums[n, 0] if rows[n, RED] > 0 else 0.0
        green = sums[n, 1] if rows[n, RED + 1] > 0 else 0.0
        blue = sums[n, 2] if rows[n, RED + 2] > 0 else 0.0
        for k in range((degree + 1) * (degree + 1)):
            at = COLOR + 3 * k
            weights[k] = red * table[i, at] + green * table[i, at + 1] + blue * table[i, at + 2]
            grad[i, at] += values[k] * red
            grad[i, at + 1] += values[k] * green
            grad[i, at + 2] += values[k] * blue
        if degree > 0:
            dx, dy, dz = slope(degree, x, y, z, weights)
            along = dx * x + dy * y + dz * z  # the length of the direction is always one
            grad[i, 0] += (dx - along * x) * inverse
            grad[i, 1] += (dy - along * y) * inverse
            grad[i, 2] += (dz - along * z) * inverse


@inlined
def _shape_back(lens, x, y, z, turn, s, back):
    """Return the gradients of point, logarithmic scales and quaternion by the covariance."""
    r, unit, shrink = rotation(turn)
    _, m, t = flattened(lens, x, y, z, r, s)
    ga, gb, gc = back
    d = (
        2 * (ga * t[0] + gb * t[3]), 2 * (ga * t[1] + gb * t[4]), 2 * (ga * t[2] + gb * t[5]),
        2 * (gb * t[0] + gc * t[3]), 2 * (gb * t[1] + gc * t[4]), 2 * (gb * t[2] + gc * t[5]),
    )  # fmt: skip
    scale = t[0] * d[0] + t[3] * d[3], t[1] * d[1] + t[4] * d[4], t[2] * d[2] + t[5] * d[5]
    quarter = _rotation_back(m, d, s, unit, shrink)
    first = (d[0] * s[0], d[1] * s[1], d[2] * s[2])
    second = (d[3] * s[0], d[4] * s[1], d[5] * s[2])
    # gradients with respect to the two rows of the projection's derivative, in the world's axes
    n = (
        first[0] * r[0] + first[1] * r[1] + first[2] * r[2],
        first[0] * r[3] + first[1] * r[4] + first[2] * r[5],
        first[0] * r[6] + first[1] * r[7] + first[2] * r[8],
        second[0] * r[0] + second[1] * r[1] + second[2] * r[2],
        second[0] * r[3] + second[1] * r[4] + second[2] * r[5],
        second[0] * r[6] + second[1] * r[7] + second[2] * r[8],
    )
    return _tilt_back(lens, x, y, z, m, n), scale, quarter


@inlined
def _tilt_back(lens, x, y, z, m, n):
    """Return the gradients of the point from those of the projection's derivative."""
    tilt_x, tilt_y = tilts(lens, x, y, z)
    j, k = lens[15] / z, lens[16] / z
    slope_x = -j * (n[0] * lens[8] + n[1] * lens[9] + n[2] * lens[10])
    slope_y = -k * (n[3] * lens[8] + n[4] * lens[9] + n[5] * lens[10])
    # a clipped tilt does not move with the point
    dx = slope_x / z if tilt_x == x / z else 0.0
    dy = slope_y / z if tilt_y == y / z else 0.0
    # each row is proportional to one over the depth
    rows = n[0] * m[0] + n[1] * m[1] + n[2] * m[2] + n[3] * m[3] + n[4] * m[4] + n[5] * m[5]
    return dx, dy, -rows / z - dx * tilt_x - dy * tilt_y


@inlined
def _rotation_back(m, d, s, unit, shrink):
    """Return the gradient of the quaternion, through its matrix and normalisation."""
    g = (
        (m[0] * d[0] + m[3] * d[3]) * s[0], (m[0] * d[1] + m[3] * d[4]) * s[1],
        (m[0] * d[2] + m[3] * d[5]) * s[2], (m[1] * d[0] + m[4] * d[3]) * s[0],
        (m[1] * d[1] + m[4] * d[4]) * s[1], (m[1] * d[2] + m[4] * d[5]) * s[2],
        (m[2] * d[0] + m[5] * d[3]) * s[0], (m[2] * d[1] + m[5] * d[4]) * s[1],
        (m[2] * d[2] + m[5] * d[5]) * s[2],
    )  # fmt: skip
    w, x, y, z = unit
    dw = 2 * (x * (g[7] - g[5]) + y * (g[2] - g[6]) + z * (g[3] - g[1]))
    dx = 2 * (y * (g[1] + g[3]) + z * (g[2] + g[6]) + w * (g[7] - g[5]) - 2 * x * (g[4] + g[8]))
    dy = 2 * (x * (g[1] + g[3]) + z * (g[5] + g[7]) + w * (g[2] - g[6]) - 2 * y * (g[0] + g[8]))
    dz = 2 * (x * (g[2] + g[6]) + y * (g[5] + g[7]) + w * (g[3] - g[1]) - 2 * z * (g[0] + g[4]))
    along = dw * w + dx * x + dy * y + dz * z
    return (
        (dw - along * w) * shrink,
        (dx - along * x) * shrink,
        (dy - along * y) * shrink,
        (dz - along * z) * shrink,
    )
