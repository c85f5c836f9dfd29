"""Compiled parts of an optimisation step that touch every vertex."""

from __future__ import annotations

import math

from fsel.core.compiled import exact

BETAS = (0.9, 0.99)
TINY = 1e-10  # beside the root of the second moment


@exact
def add_variation(rows, values, weight, bend, gradient):
    """Gradient of the total variation: Huber's norm of each difference between neighbours.

    The norm of a difference d is d^2 / (2 bend) up to `bend`, and |d| - bend / 2 beyond.

    Args:
        rows: (n, 3) int32 of `Grid.neighbours`.
        values: (n, m).
        weight: of the sum over all differences.
        bend: above zero.
        gradient: (n, m), added to.
    """
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
    """One step of Adam (Kingma and Ba 2015), and the gradient is zero again.

    Numbers whose gradient is zero rest: what no ray meets is not moved by its past.

    Args:
        values, gradient: flat.
        moments: first and second, flat.
        rate: step size.
        turn: number of the step, from 1.
    """
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
