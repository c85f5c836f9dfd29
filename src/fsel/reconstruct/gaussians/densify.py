"""Relocation of faint Gaussians and growth within a budget: 3DGS-MCMC (Kheradmand et al. 2024).

A Gaussian of opacity o that becomes n Gaussians in one place gets the opacities and the scales at
which the n together look as it did (their equation 9).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from fsel.reconstruct.gaussians.parameters import LOGIT, SCALE

DEAD = 0.005  # opacity at which a Gaussian is relocated
GROWTH = 1.05  # of the number of Gaussians, at each relocation, until the budget is full
MOST = 51  # Gaussians that one may become
LARGEST = 1 - 1e-7  # opacity


def split_opacity(opacity: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the opacity of each of `shares` Gaussians that together pass the light of one."""
    return 1 - (1 - opacity) ** (1 / shares)


def split_scale(opacity: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the factor of the standard deviations at which they keep the mass along a ray."""
    part = split_opacity(opacity, shares)
    powers = part[..., None] ** np.arange(1, MOST + 1)
    return opacity / (powers * _coefficients()[shares]).sum(axis=-1)


@cache
def _coefficients() -> np.ndarray:
    """Return (MOST + 1, MOST) factors of the part's powers, a row a number of Gaussians."""
    table = np.zeros((MOST + 1, MOST))
    for n in range(1, MOST + 1):
        for k in range(n):
            # the binomials of column k add to the next column's
            table[n, k] = math.comb(n, k + 1) * (-1) ** k / math.sqrt(k + 1)
    return table


def relocate(table: np.ndarray, alive: int, rng: np.random.Generator) -> tuple[int, np.ndarray]:
    """Move dead Gaussians of a (budget, c) table onto living ones, drawn by their opacities, and
    add new ones while the budget lasts; return the rows in use afterwards, and those that
    changed."""
    opacity = 1 / (1 + np.exp(-table[:alive, LOGIT].astype(np.float64)))
    dead = np.flatnonzero(opacity <= DEAD)
    weight = np.where(opacity > DEAD, opacity, 0.0)
    grown = min(len(table), int(GROWTH * alive))
    guests = np.concatenate([dead, np.arange(alive, grown)])
    if not weight.any() or not len(guests):
        return alive, guests[:0]
    hosts = rng.choice(alive, len(guests), p=weight / weight.sum())
    shares = np.minimum(np.bincount(hosts, minlength=alive) + 1, MOST)
    split = np.flatnonzero(shares > 1)
    whole = np.minimum(opacity[split], LARGEST)
    part = np.maximum(split_opacity(whole, shares[split]), DEAD)
    table[split, LOGIT] = np.log(part / (1 - part))
    table[split, SCALE] += np.log(split_scale(whole, shares[split]))[:, None]
    table[guests] = table[hosts]
    return grown, np.concatenate([split, guests])
