"""The compiled greedy loops of a linear scorer and of a network.

All of it is float64, but for a network's first look: every row is scored in float32 with a
polynomial GELU, and those that could be the best again in float64 with the exact one, so that
neither rounding nor the processor decides a pick. Slow twin: `fsel.selectors.reference_loop`.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact, exact_part, inlined, reordered_part
from fsel.features.columns import FOLLOWING, FOLLOWING_INPUTS, GAIN
from fsel.features.static import FLAT
from fsel.selectors.conditioned_kernels import begin, update
from fsel.selectors.scorer import WIDTH

BLOCK = 64  # rows a matrix product: its operands stay in the first cache, and on one thread
ROUNDING = 1e-4  # float32 scores err by less than this share of their terms' magnitude

# Phi(z) = (1 + z P(s)) / 2 with s = 2 (z / 5)^2 - 1 for |z| <= 5.
# Coefficients of P are in ascending powers of s: a minimax fit of degree 11, whose GELU errs by
# less than 5e-6.
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


@exact_part
def _scale(column, selectable):
    """Mean of a column over the rows still selectable, and one over its deviation, 0 if flat."""
    total, scale, count = 0.0, 0.0, 0
    for i in range(len(column)):
        if selectable[i]:
            total += column[i]
            scale = max(scale, abs(column[i]))
            count += 1
    mean = total / max(count, 1)
    spread = 0.0
    for i in range(len(column)):
        if selectable[i]:
            spread += (column[i] - mean) ** 2
    deviation = math.sqrt(spread / max(count, 1))
    return mean, 1 / deviation if deviation > FLAT * scale else 0.0


@exact
def standardise_rows(raw, selectable, out):
    """Write z-scores of (5, n) columns, the target gain as it is, to (n, 5) `out`; picks: zero."""
    for i in range(len(selectable)):
        out[i, GAIN] = raw[GAIN, i] if selectable[i] else 0.0
    for c in range(GAIN):
        mean, factor = _scale(raw[c], selectable)
        for i in range(len(selectable)):
            out[i, c] = (raw[c, i] - mean) * factor if selectable[i] else 0.0


@exact_part
def _best_of(scores, selectable):
    """The row with the highest score of those not yet picked; ties go to the lowest."""
    best = -1
    for i in range(len(scores)):
        if selectable[i] and (best < 0 or scores[i] > scores[best]):
            best = i
    return best


@exact
def run_linear(k, fixed, coefficients, rows, picks, scores):
    """Run the greedy loop (paper, Eq. 1 and 2) with a linear scorer; write (k,) picks and scores.

    Args:
        k: how many picks.
        fixed: (n,) float64 part of the scores that no pick changes.
        coefficients: (5,) float64 of the inputs that follow the selection.
        rows: see `fsel.selectors.greedy.Rows`.
        picks, scores: (k,) int64 and float64.
    """
    n = len(fixed)
    raw, memory = begin(rows)
    selectable = np.ones(n, np.bool_)
    for step in range(k):
        total = fixed.copy()
        for c in range(FOLLOWING):
            if coefficients[c] != 0:
                mean, factor = _scale(raw[c], selectable) if c != GAIN else (0.0, 1.0)
                for i in range(n):
                    total[i] += coefficients[c] * ((raw[c, i] - mean) * factor)
        row = _best_of(total, selectable)
        picks[step], scores[step] = row, total[row]
        selectable[row] = False
        update(row, selectable, rows, memory, raw)


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


@reordered_part
def _score_block(block, base, inputs, narrow, hidden, product, out):
    """Write float32 scores, less the last bias, of up to 64 rows."""
    first, second, second_bias, third = narrow
    for i in range(len(block)):
        row = block[i]
        a, b, c = np.float32(inputs[row, 0]), np.float32(inputs[row, 1]), np.float32(inputs[row, 2])
        d, e = np.float32(inputs[row, 3]), np.float32(inputs[row, 4])
        for j in range(WIDTH):
            z = base[row, j] + a * first[0, j] + b * first[1, j]
            hidden[i, j] = _gelu(z + c * first[2, j] + d * first[3, j] + e * first[4, j])
    np.dot(hidden[: len(block)], second, product[: len(block)])
    for i in range(len(block)):
        total = np.float32(0)
        for j in range(WIDTH):
            total += third[j] * _gelu(product[i, j] + second_bias[j])
        out[block[i]] = total


@exact_part
def _approximate_scores(selectable, base, inputs, narrow, out):
    """Write (n,) float32 scores, less the last bias, of the rows not yet picked, given (n, 64)
    `base` of the first layer that no pick changes; return those rows."""
    hidden, product = np.empty((BLOCK, WIDTH), np.float32), np.empty((BLOCK, WIDTH), np.float32)
    rows = np.flatnonzero(selectable)
    for start in range(0, len(rows), BLOCK):
        block = rows[start : start + BLOCK]
        _score_block(block, base, inputs, narrow, hidden, product, out)
    return rows


@exact_part
def _exact_score(static, inputs, wide):
    """One row's float64 score with the exact GELU, and the magnitude of its terms; (19,) `static`
    inputs and (5,) that follow the selection."""
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


@exact_part
def _best_row(rows, approximate, static, inputs, wide):
    """The best of some rows and its float64 score, the lowest of equals."""
    top = rows[0]
    for i in rows:
        top = i if approximate[i] > approximate[top] else top
    best = top
    best_score, magnitude = _exact_score(static[top], inputs[top], wide)
    limit = approximate[top] - ROUNDING * magnitude
    for i in rows:
        if approximate[i] >= limit and i != top:
            score = _exact_score(static[i], inputs[i], wide)[0]
            if score > best_score or (score == best_score and i < best):
                best, best_score = i, score
    return best, best_score


@exact
def run_network(k, static, base, rows, layers, picks, scores):
    """Run the greedy loop (paper, Eq. 1 and 2) with a network; write (k,) picks and scores.

    Args:
        k: how many picks.
        static: (n, 19) float64 inputs, without what the selection adds to those that follow it.
        base: (n, 64) float32, see `_approximate_scores`.
        rows: see `fsel.selectors.greedy.Rows`.
        layers: see `fsel.selectors.scorer.Layers`.
        picks, scores: (k,) int64 and float64.
    """
    n = len(static)
    raw, memory = begin(rows)
    selectable = np.ones(n, np.bool_)
    inputs, approximate = np.empty((n, FOLLOWING)), np.empty(n, np.float32)
    for step in range(k):
        standardise_rows(raw, selectable, inputs)
        free = _approximate_scores(selectable, base, inputs, layers.narrow, approximate)
        row, scores[step] = _best_row(free, approximate, static, inputs, layers.wide)
        picks[step] = row
        selectable[row] = False
        update(row, selectable, rows, memory, raw)
