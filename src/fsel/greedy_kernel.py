"""The compiled greedy loop: running extrema, their z-scores, the network, the argmax.

Geometry and z-scores are float64. The network screens all candidates in float32 and with a
polynomial GELU; every candidate that could still be the best is then scored again in float64 with
the exact one, so that neither rounding nor the processor's vector width decides a pick.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from fsel.features import FLAT
from fsel.geometry import SAME_AXIS

COLUMNS = 5  # d_min_s, gamma_min_s, rho_max_s, phi_nov, coverage gain
WIDTH = 64
BLOCK = 64  # rows a matrix product: its operands stay in the first cache, and on one thread
SCREEN = 1e-4  # float32 scores err by less than this share of their terms' magnitude

# Phi(z) = (1 + z P(s)) / 2 with s = 2 (z / 5)^2 - 1 for |z| <= 5, ascending powers of s: a minimax
# fit of degree 11 whose GELU errs by less than 5e-6.
_P = np.array(
    [
        *(
            0.28272750973701477,
            -0.14059646427631378,
            0.10305079072713852,
            -0.08078396320343018,
        ),
        *(
            0.06271345913410187,
            -0.047249920666217804,
            0.03382023051381111,
            -0.02033086121082306,
        ),
        *(0.010226593352854252, -0.0077738091349601746, 0.006388887297362089),
        -0.002192680025473237,
    ],
    np.float32,
)
_P0, _P1, _P2, _P3, _P4, _P5, _P6, _P7, _P8, _P9, _P10, _P11 = _P
_FIVE, _HALF, _ONE, _SQUARE = (np.float32(v) for v in (5, 0.5, 1, 2 / 25))

_f32 = np.float32
_jit = numba.njit(cache=True, nogil=True)
_fast = numba.njit(cache=True, nogil=True, fastmath=True)


@_jit
def fold(row, first, centers, axes, bearings, descriptors, kernel, squares, covered, raw):
    """Fold one pick into the running extrema.

    Args:
        row: the pick.
        first: whether it is the first pick.
        centers, axes, bearings: (n, 3) float64.
        descriptors: (n, D) float32; kernel: (n, O) float64; D or O may be 0.
        squares: (3, n) squared distance and chords to the nearest pick; changed.
        covered: (O,) summed kernel of the picks; changed.
        raw: (5, n) raw columns; changed.
    """
    _nearest(centers, row, squares[0], raw[0])
    _smallest_angle(axes, row, squares[1], raw[1])
    _smallest_angle(bearings, row, squares[2], raw[3])
    if descriptors.shape[1] > 0:
        _likest(descriptors, row, first, raw[2])
    if len(covered) > 0:
        for o in range(len(covered)):
            covered[o] += kernel[row, o]
        coverage_gain(kernel, covered, raw[4])


@_jit
def _nearest(points, row, squares, out):
    x, y, z = points[row, 0], points[row, 1], points[row, 2]
    for i in range(len(points)):
        gap = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        if gap < squares[i]:
            squares[i] = gap
            out[i] = math.sqrt(gap)


@_jit
def _smallest_angle(vectors, row, squares, out):
    """2 atan2(|a - b|, |a + b|), taken only where the chord |a - b| has shrunk."""
    x, y, z = vectors[row, 0], vectors[row, 1], vectors[row, 2]
    for i in range(len(vectors)):
        a, b, c = vectors[i, 0], vectors[i, 1], vectors[i, 2]
        chord = (a - x) ** 2 + (b - y) ** 2 + (c - z) ** 2
        if chord < squares[i]:
            squares[i] = chord
            total = (a + x) ** 2 + (b + y) ** 2 + (c + z) ** 2
            chord = math.sqrt(chord) if chord > SAME_AXIS**2 else 0.0
            out[i] = 2 * math.atan2(chord, math.sqrt(total))


@_fast
def _likest(descriptors, row, first, out):
    for i in range(len(descriptors)):
        likeness = 0.0
        for d in range(descriptors.shape[1]):
            likeness += np.float64(descriptors[i, d]) * np.float64(descriptors[row, d])
        if first or likeness > out[i]:
            out[i] = likeness


@_fast
def coverage_gain(kernel, covered, out):
    """Each row's mean closeness to the views, each view discounted by what covers it."""
    discount = 1 / (1 + covered)
    for i in range(len(kernel)):
        gain = 0.0
        for o in range(len(discount)):
            gain += kernel[i, o] * discount[o]
        out[i] = gain / max(len(discount), 1)


@_jit
def standardise_rows(raw, rows, out):
    """Write z-scores over the rows still selectable of all (5, n) columns but the last, the
    coverage gain, which is copied, to `out` (n, 5) float64.

    Population deviation; a flat column, and a row that was picked, becomes zero.
    """
    count = rows.sum()
    for i in range(len(rows)):
        out[i, COLUMNS - 1] = raw[COLUMNS - 1, i] if rows[i] else 0.0
    for c in range(COLUMNS - 1):
        column = raw[c]
        total = 0.0
        scale = 0.0
        for i in range(len(column)):
            if rows[i]:
                total += column[i]
                scale = max(scale, abs(column[i]))
        mean = total / max(count, 1)
        spread = 0.0
        for i in range(len(column)):
            if rows[i]:
                spread += (column[i] - mean) ** 2
        deviation = math.sqrt(spread / max(count, 1))
        factor = 1 / deviation if deviation > FLAT * scale else 0.0
        for i in range(len(column)):
            out[i, c] = (column[i] - mean) * factor if rows[i] else 0.0


@numba.njit(inline="always", fastmath=True)
def _gelu(z):
    x = min(max(z, -_FIVE), _FIVE)
    s = x * x * _SQUARE - _ONE
    p = _P11 * s + _P10
    p = p * s + _P9
    p = p * s + _P8
    p = p * s + _P7
    p = p * s + _P6
    p = p * s + _P5
    p = p * s + _P4
    p = p * s + _P3
    p = p * s + _P2
    p = p * s + _P1
    p = p * s + _P0
    return _HALF * z * (_ONE + x * p)


@_fast
def screen(base, inputs, layers, out):
    """Write float32 scores, less the last bias, of all rows to `out` (n,).

    Args:
        base: (n, 64) float32 part of the first layer that the selection leaves alone.
        inputs: (n, 5) float64, see `standardise_rows`.
        layers: float32 (5, 64) first-layer weights of those columns, (64, 64) second layer
            transposed and its (64,) bias, (64,) third layer.
        out: (n,) float32.
    """
    dynamic, second, second_bias, third = layers
    hidden = np.empty((BLOCK, WIDTH), np.float32)
    product = np.empty((BLOCK, WIDTH), np.float32)
    for start in range(0, len(base), BLOCK):
        rows = min(BLOCK, len(base) - start)
        for i in range(rows):
            a, b, c = (
                _f32(inputs[start + i, 0]),
                _f32(inputs[start + i, 1]),
                _f32(inputs[start + i, 2]),
            )
            d, e = _f32(inputs[start + i, 3]), _f32(inputs[start + i, 4])
            for j in range(WIDTH):
                z = base[start + i, j] + a * dynamic[0, j] + b * dynamic[1, j]
                hidden[i, j] = _gelu(z + c * dynamic[2, j] + d * dynamic[3, j] + e * dynamic[4, j])
        np.dot(hidden[:rows], second, product[:rows])
        for i in range(rows):
            total = _f32(0)
            for j in range(WIDTH):
                total += third[j] * _gelu(product[i, j] + second_bias[j])
            out[start + i] = total


@_jit
def exact_score(static, inputs, columns, layers):
    """One row's float64 score with the exact GELU, and the magnitude of its terms.

    Args:
        static: (19,) inputs that the selection leaves alone.
        inputs: (5,) those that follow it.
        columns: (5,) where the latter go among the former.
        layers: the scorer's six arrays in their own shapes, float64.
    """
    first, first_bias, second, second_bias, third, third_bias = layers
    x = static.copy()
    for c in range(COLUMNS):
        x[columns[c]] += inputs[c]
    hidden = np.empty(WIDTH)
    for j in range(WIDTH):
        z = first_bias[j]
        for c in range(len(x)):
            z += first[j, c] * x[c]
        hidden[j] = 0.5 * z * (1 + math.erf(z * math.sqrt(0.5)))
    score = third_bias[0]
    magnitude = abs(score)
    for j in range(WIDTH):
        z = second_bias[j]
        for c in range(WIDTH):
            z += second[j, c] * hidden[c]
        term = third[0, j] * 0.5 * z * (1 + math.erf(z * math.sqrt(0.5)))
        score += term
        magnitude += abs(term)
    return score, magnitude


@_jit
def best_row(approximate, selectable, static, inputs, columns, layers):
    """The best selectable row and its float64 score, among those that screening leaves open.

    Ties go to the lowest row.
    """
    top = -1
    for i in range(len(approximate)):
        if selectable[i] and (top < 0 or approximate[i] > approximate[top]):
            top = i
    best = top
    best_score, magnitude = exact_score(static[top], inputs[top], columns, layers)
    limit = approximate[top] - SCREEN * magnitude
    for i in range(len(approximate)):
        if selectable[i] and approximate[i] >= limit and i != top:
            score = exact_score(static[i], inputs[i], columns, layers)[0]
            if score > best_score or (score == best_score and i < best):
                best, best_score = i, score
    return best, best_score


@_jit
def run(k, columns, static, base, relations, narrow, wide, picks, scores):
    """The greedy loop (paper, Eq. 1 and 2).

    Args:
        k: how many picks.
        columns: (5,) the inputs that follow the selection.
        static: (n, 19) float64 inputs, without what those columns get from the selection.
        base: (n, 64) float32, see `screen`.
        relations: centers, axes, bearings, descriptors, kernel, see `fold`.
        narrow: float32 layers, see `screen`.
        wide: float64 layers, see `exact_score`.
        picks: (k,) int64, written.
        scores: (k,) float64, written.
    """
    centers, axes, bearings, descriptors, kernel = relations
    n = len(static)
    raw = np.zeros((COLUMNS, n))
    squares = np.full((3, n), np.inf)
    covered = np.zeros(kernel.shape[1])
    coverage_gain(kernel, covered, raw[4])
    selectable = np.ones(n, np.bool_)
    inputs = np.empty((n, COLUMNS))
    approximate = np.empty(n, np.float32)
    for step in range(k):
        standardise_rows(raw, selectable, inputs)
        screen(base, inputs, narrow, approximate)
        row, scores[step] = best_row(approximate, selectable, static, inputs, columns, wide)
        picks[step] = row
        selectable[row] = False
        fold(
            row,
            step == 0,
            centers,
            axes,
            bearings,
            descriptors,
            kernel,
            squares,
            covered,
            raw,
        )
