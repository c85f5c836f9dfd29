"""Adam on the visible Gaussians (Taming 3DGS, Mallick et al. 2024), the learning rates of Kerbl et
al. 2023, and the penalties and the noise of 3DGS-MCMC (Kheradmand et al. 2024).

The published rates are for 30,000 steps; a shorter training multiplies all but the opacity's by
sqrt(30,000 / steps).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from fsel.core.compiled import reordered, reordered_part
from fsel.core.threads import ranges, spread
from fsel.reconstruct.gaussians.parameters import COLOR, LOGIT, MEAN, SCALE, TURN, width_of
from fsel.reconstruct.gaussians.rasterize import exponential

PUBLISHED_STEPS = 30_000
MEAN_RATES = (1.6e-4, 1.6e-6)  # first and last, times the scene's extent
RATES = {"scale": 5e-3, "turn": 1e-3, "logit": 5e-2, "color": 2.5e-3, "harmonics": 1.25e-4}
EXTENT = 1.1  # in the normalised frame the farthest camera is at 1, and Kerbl et al. add a tenth
DECAYS = (0.9, 0.999)
TINY = 1e-15  # Kerbl et al.: gradients are far below Adam's usual epsilon
PENALTIES = (0.01, 0.01)  # weights of the mean opacity, and of the mean deviation in radii
NOISE = 5e5  # times the means' published rate: the noise's size (Kheradmand et al. 2024)
FAINT, SHARP = 0.005, 100.0  # opacity at which the noise is halved, and how fast it falls above
FEWEST = 512  # Gaussians of a range
SILENT = math.log(0.1 / 0.9)  # logit of the opacity above which it is below 1e-4 of its size


class Rates:
    """Step sizes of a training of some length, over which the means' rate falls exponentially."""

    def __init__(self, degree: int, steps: int) -> None:
        self.steps = steps
        self.pace = max(1.0, math.sqrt(PUBLISHED_STEPS / max(steps, 1)))
        self._others = np.ones(width_of(degree), np.float32)
        self._others[SCALE], self._others[TURN] = RATES["scale"], RATES["turn"]
        self._others[COLOR : COLOR + 3] = RATES["color"]
        self._others[COLOR + 3 :] = RATES["harmonics"]
        self._others *= self.pace
        self._others[LOGIT] = RATES["logit"]

    def published_mean(self, step: int) -> float:
        """Return the published rate of the means at a step."""
        first, last = MEAN_RATES
        return EXTENT * first * (last / first) ** (step / self.steps)

    def at(self, step: int) -> np.ndarray:
        """Return (c,), one a column of the table, until the next call."""
        self._others[MEAN] = self.pace * self.published_mean(step)
        return self._others

    def noise(self, step: int) -> float:
        """Return the size of the noise at a step."""
        return NOISE * self.published_mean(step)


class Adam:
    """The state of the optimiser of (n, c) parameters, which are updated in place."""

    def __init__(self, table: np.ndarray, rates: Rates) -> None:
        self.table, self.rates = table, rates
        self.first, self.second = np.zeros_like(table), np.zeros_like(table)
        self.count = np.zeros(len(table), np.int64)
        past = np.arange(1, rates.steps + 2)
        self.corrections = np.stack([1 - decay**past for decay in DECAYS]).astype(table.dtype)

    def step(self, grad: np.ndarray, touched: np.ndarray, step: int) -> None:
        """Update the touched rows, and clear their gradients."""
        state = self.first, self.second, self.count
        _update(self.table, grad, *state, touched, self.rates.at(step), self.corrections)

    def forget(self, rows: np.ndarray) -> None:
        """Start anew with some rows."""
        self.first[rows], self.second[rows], self.count[rows] = 0, 0, 0


@reordered
def _update(table, grad, first, second, count, touched, rates, corrections):
    kind = table.dtype.type
    keep1, keep2, one = kind(DECAYS[0]), kind(DECAYS[1]), kind(1)
    tiny, none = kind(TINY), kind(0)
    for i in touched:
        size = kind(1) / corrections[0, count[i]]
        spread = kind(1) / np.sqrt(corrections[1, count[i]])
        count[i] = min(count[i] + 1, corrections.shape[1] - 1)
        row, slope, mean, square = table[i], grad[i], first[i], second[i]
        for c in range(len(rates)):
            g = slope[c]
            m = keep1 * mean[c] + (one - keep1) * g
            v = keep2 * square[c] + (one - keep2) * g * g
            mean[c], square[c], slope[c] = m, v, none
            row[c] -= rates[c] * size * m / (np.sqrt(v) * spread + tiny)


@reordered
def penalise(table, grad, touched, opacity, scale):
    """Add the gradients of `opacity` times the mean opacity and `scale` times the mean standard
    deviation, of the touched rows; the means are over all."""
    kind = table.dtype.type
    opacity, scale = kind(opacity / len(table)), kind(scale / (3 * len(table)))
    one, most = kind(1), kind(80)  # beyond it an exponential is as good as zero, or infinite
    for i in touched:
        value = one / (one + exponential(max(min(-table[i, LOGIT], most), -most)))
        grad[i, LOGIT] += opacity * value * (one - value)
        for axis in range(3, 6):
            grad[i, axis] += scale * exponential(max(min(table[i, axis], most), -most))


def shake(table, touched, rng, size):
    """Move faint Gaussians at random, along their own axes, the farther the fainter."""
    faint = touched[table[touched, LOGIT] < np.float64(SILENT)]
    drawn = rng.standard_normal((len(faint), 3))
    spread(partial(_shift_all, table, faint, drawn, size), ranges(len(faint), FEWEST))


@reordered
def _shift_all(table, faint, drawn, size, first, last):
    for n in range(first, last):
        i = faint[n]
        opacity = 1 / (1 + math.exp(-table[i, LOGIT]))
        reach = size / (1 + math.exp(SHARP * (opacity - FAINT)))
        _shift(table[i], drawn[n], reach)


@reordered_part
def _shift(row, drawn, reach):
    """Add the covariance times a normal vector (3,)."""
    w, x, y, z = row[6], row[7], row[8], row[9]
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    a, b, c = drawn[0], drawn[1], drawn[2]
    axes = (
        (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
    )
    for k in range(3):
        axis = axes[k]
        along = axis[0] * a + axis[1] * b + axis[2] * c
        step = reach * math.exp(2 * row[3 + k]) * along
        for d in range(3):
            row[d] += step * axis[d]
