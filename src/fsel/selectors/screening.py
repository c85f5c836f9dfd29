"""The compiled network of the greedy loop, and which rows it need not look at.

All rows that could be the best are scored in float32 and with a polynomial GELU; every one that
could still be the best is then scored again in float64 with the exact one, so that neither rounding
nor the processor's vector width decides a pick. A row could be the best only if its last score, and
how far its inputs have moved since, allow it: see `fsel.selectors.scorer.change_bounds`.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact, inlined, reordered
from fsel.features.columns import FOLLOWING, FOLLOWING_INPUTS
from fsel.selectors.scorer import WIDTH

BLOCK = 64  # rows a matrix product: its operands stay in the first cache, and on one thread
SCREEN = 1e-4  # float32 scores err by less than this share of their terms' magnitude

# Phi(z) = (1 + z P(s)) / 2 with s = 2 (z / 5)^2 - 1 for |z| <= 5, ascending powers of s: a minimax
# fit of degree 11 whose GELU errs by less than 5e-6.
_P = np.array(
    [
        *(0.28272750973701477, -0.14059646427631378, 0.10305079072713852, -0.08078396320343018),
        *(0.06271345913410187, -0.047249920666217804, 0.03382023051381111, -0.02033086121082306),
        *(0.010226593352854252, -0.0077738091349601746, 0.006388887297362089),
        -0.002192680025473237,
    ],
    np.float32,
)
_P0, _P1, _P2, _P3, _P4, _P5, _P6, _P7, _P8, _P9, _P10, _P11 = _P
_FIVE, _HALF, _ONE, _SQUARE = (np.float32(v) for v in (5, 0.5, 1, 2 / 25))

_f32 = np.float32


@reordered
def highest(scored, inputs, seen, bounds, out):
    """Write the (n,) scores that rows could have at most, given those that they had.

    Args:
        scored: (n,) float32 scores of the inputs `seen`, (n, 5) float64.
        inputs: (n, 5) float64 of today.
        bounds: see `fsel.selectors.scorer.change_bounds`.
        out: (n,) float64.
    """
    moved = np.empty(FOLLOWING)
    for i in range(len(scored)):
        for c in range(FOLLOWING):
            moved[c] = inputs[i, c] - seen[i, c]
        total = np.float64(scored[i])
        for c in range(FOLLOWING):
            total += bounds[0, c] * moved[c]
        for part in range(2):
            square = 0.0
            for r in range(FOLLOWING):
                value = 0.0
                for c in range(r, FOLLOWING):
                    value += bounds[1 + part * FOLLOWING + r, c] * moved[c]
                square += value * value
            total += math.sqrt(square)
        out[i] = total


@inlined
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


@reordered
def _score_block(block, base, inputs, narrow, hidden, product, out, seen):
    """Write float32 scores, less the last bias, of up to 64 rows, and the inputs that gave them."""
    first, second, second_bias, third = narrow
    for i in range(len(block)):
        row = block[i]
        for column in range(FOLLOWING):
            seen[row, column] = inputs[row, column]
        a, b, c = _f32(inputs[row, 0]), _f32(inputs[row, 1]), _f32(inputs[row, 2])
        d, e = _f32(inputs[row, 3]), _f32(inputs[row, 4])
        for j in range(WIDTH):
            z = base[row, j] + a * first[0, j] + b * first[1, j]
            hidden[i, j] = _gelu(z + c * first[2, j] + d * first[3, j] + e * first[4, j])
    np.dot(hidden[: len(block)], second, product[: len(block)])
    for i in range(len(block)):
        total = _f32(0)
        for j in range(WIDTH):
            total += third[j] * _gelu(product[i, j] + second_bias[j])
        out[block[i]] = total


@exact
def exact_score(static, inputs, wide):
    """One row's float64 score with the exact GELU, and the magnitude of its terms.

    Args:
        static: (19,) inputs that the selection leaves alone.
        inputs: (5,) those that follow it.
        wide: see `fsel.selectors.scorer.Wide`.
    """
    first, first_bias, second, second_bias, third, third_bias = wide
    x = static.copy()
    for c in range(FOLLOWING):
        x[FOLLOWING_INPUTS[c]] += inputs[c]
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


@exact
def screen(most, selectable, static, base, inputs, layers, out, seen):
    """Score the rows that could be the best, and say which they were.

    The row that was best of those left sets the bar; every row that beats it raises it.

    Args:
        most: (n,) float64, see `highest`.
        selectable: (n,) bool, rows not yet picked.
        static, inputs: of all rows, see `exact_score`.
        base: (n, 64) float32 part of the first layer that the selection leaves alone.
        layers: see `fsel.selectors.scorer.Layers`.
        out: (n,) float32 last scores, less the last bias; changed.
        seen: (n, 5) float64 inputs that gave them; changed.

    Returns:
        (m,) int64 rows, ascending.
    """
    top = best_of(out, selectable)
    score, magnitude = exact_score(static[top], inputs[top], layers.wide)
    margin = SCREEN * magnitude
    bar = score - layers.wide.third_bias[0] - margin
    hidden = np.empty((BLOCK, WIDTH), np.float32)
    product = np.empty((BLOCK, WIDTH), np.float32)
    rows = np.empty(len(most), np.int64)
    done, count = 0, 0
    for i in range(len(most)):
        if selectable[i] and (most[i] >= bar or i == top):
            rows[done + count] = i
            count += 1
        if count == BLOCK or i == len(most) - 1:
            block = rows[done : done + count]
            _score_block(block, base, inputs, layers.narrow, hidden, product, out, seen)
            for row in block:
                bar = max(bar, out[row] - margin)
            done, count = done + count, 0
    return rows[:done]


@exact
def best_of(scores, selectable):
    """The row with the highest score of those not yet picked; ties go to the lowest."""
    best = -1
    for i in range(len(scores)):
        if selectable[i] and (best < 0 or scores[i] > scores[best]):
            best = i
    return best


@exact
def best_row(rows, approximate, static, inputs, wide):
    """The best of some rows and its float64 score, among those that screening leaves open.

    Ties go to the lowest row.
    """
    top = rows[np.argmax(approximate[rows])]
    best = top
    best_score, magnitude = exact_score(static[top], inputs[top], wide)
    limit = approximate[top] - SCREEN * magnitude
    for i in rows:
        if approximate[i] >= limit and i != top:
            score = exact_score(static[i], inputs[i], wide)[0]
            if score > best_score or (score == best_score and i < best):
                best, best_score = i, score
    return best, best_score
