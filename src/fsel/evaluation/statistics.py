"""Intervals and tests that hold for few scenes.

The unit of chance is the place: scenes of one place, and draws of one scene, are averaged first.
Draws then need no model of their own, since a place's mean carries their noise. A percentile
bootstrap over two places and their draws, nominally 5 %, rejects a true null in 27 % of trials;
Student's t on the means of places keeps to 5 % from two places on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

LEVEL = 0.95
LEAST_P = 1e-12  # a smaller p counts as this


class Interval(NamedTuple):
    """A mean and what is known of it.

    Attributes:
        mean: of the places' means.
        low, high: bounds of the 95 % interval; NaN for a single place, which says nothing about
            others.
        p: two-sided, of the mean being zero; NaN likewise.
        n: places.
    """

    mean: float
    low: float
    high: float
    p: float
    n: int

    @property
    def excludes_zero(self) -> bool:
        """Say whether zero lies outside of the bounds; never where there are none."""
        return self.low > 0 or self.high < 0


def of_places(values: np.ndarray) -> Interval:
    """Compute Student's t interval of a mean of (n,) independent values, one a place."""
    from scipy.special import stdtr, stdtrit  # here: every start of the workflow imports it

    n = len(values)
    mean = float(np.mean(values))
    if n < 2:
        return Interval(mean, np.nan, np.nan, np.nan, n)
    error = float(np.std(values, ddof=1)) / np.sqrt(n)
    if error == 0:
        return Interval(mean, mean, mean, float(mean == 0), n)
    half = float(stdtrit(n - 1, (1 + LEVEL) / 2)) * error
    p = 2 * float(stdtr(n - 1, -abs(mean) / error))
    return Interval(mean, mean - half, mean + half, p, n)


def of_places_and_seeds(values: np.ndarray) -> Interval:
    """Compute the interval of the mean of (n, s) values over places and training seeds, as samples.

    A seed moves all places together, which the places' spread does not show. The squared reach of
    the interval is the sum of both parts' variances, each times the square of its own Student
    quantile: never too narrow (Banerjee 1960), and as narrow as without seeds where they do not
    differ by more than the residual explains.
    """
    from scipy.special import stdtrit

    n, s = values.shape
    if s < 2 or n < 2:
        return of_places(values.mean(axis=1))
    places, seeds = values.mean(axis=1), values.mean(axis=0)
    residual = values - places[:, None] - seeds + values.mean()
    noise = np.sum(residual**2) / ((n - 1) * (s - 1)) / n
    of_seeds = max(np.var(seeds, ddof=1) - noise, 0.0) / s
    if of_seeds == 0:
        return of_places(places)
    mean, variances = float(places.mean()), np.array([np.var(places, ddof=1) / n, of_seeds])

    def reach(p: float) -> float:
        return float(np.sqrt(np.sum(stdtrit([n - 1, s - 1], p / 2) ** 2 * variances)))

    half = reach(1 - LEVEL)
    p = LEAST_P if reach(LEAST_P) < abs(mean) else 1.0
    if mean and p == 1:
        from scipy.optimize import brentq  # here: slow to import, and seldom needed

        p = brentq(lambda p: reach(p) - abs(mean), LEAST_P, 1.0)
    return Interval(mean, mean - half, mean + half, p, n)


def ahead_of_all(gaps: np.ndarray, p: np.ndarray) -> float:
    """Compute p of a method being ahead of every rival, given (m,) `gaps` to them and their
    two-sided p: the weakest comparison decides (intersection-union test, Berger 1982); NaN where
    unknown."""
    return float(np.max(np.where((gaps > 0) | np.isnan(p), p, 1.0)))


def holm(p: np.ndarray) -> np.ndarray:
    """Adjust (m,) p-values of tests read together by Holm (1979), in their order; NaN stays NaN."""
    adjusted = np.full(len(p), np.nan)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known], kind="stable")]
    scaled = p[order] * np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0) if len(order) else scaled
    return adjusted
