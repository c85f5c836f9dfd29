"""Opacity and depth by agreement between the depth maps of a subset, block by block of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.reconstruct.splats import fusion

# of verdicts in memory at once: 900 maps at 64x48, 8 neighbours each. More are made anew in
# every round
VERDICT_BYTES = 1 << 28
PAIR_BYTES = 12  # of a pixel and a neighbour, see `fusion.Verdicts`


class Maps(NamedTuple):
    """K depth maps, and how each is carried into the M that it is compared with."""

    inverse: np.ndarray  # (K, h, w) float32 inverse depth
    rays: np.ndarray  # (K, 2, h, w) float32, x/z and y/z of every pixel
    neighbours: np.ndarray  # (K, M) int64 rows
    rotation: np.ndarray  # (K, M, 3, 3) float32, camera to neighbour
    translation: np.ndarray  # (K, M, 3) float32
    ks: np.ndarray  # (K, 4) float32 intrinsics
    tolerance: np.ndarray  # (K,) float32 inverse depth


def agreed(
    maps: Maps, opacity: np.ndarray, rounds: int, against: float
) -> tuple[np.ndarray, np.ndarray]:
    """Vote for some rounds, then average every depth with those that agree with it.

    Args:
        maps: the depth maps.
        opacity: (K, h, w) float32, how sure matching is of each pixel, 0..1.
        rounds, against: see `fsel.reconstruct.splats.reconstructor.SplatSettings`.

    Returns:
        (K, h, w) float32 inverse depths, and (K, h, w) float32 opacities. Blocks change no bit.
    """
    count, neighbours = maps.neighbours.shape
    each = neighbours * (maps.inverse[0].size + 1) * PAIR_BYTES
    step = max(1, VERDICT_BYTES // each)
    rows = [slice(first, first + step) for first in range(0, count, step)]

    def compared(own: slice) -> fusion.Verdicts:
        there = maps.neighbours[own], maps.rotation[own], maps.translation[own]
        given = own.start, maps.inverse, maps.rays, *there, maps.ks, maps.tolerance[own]
        return fusion.compare(*given)

    kept = compared(rows[0]) if len(rows) == 1 else None

    def voted(own: slice) -> np.ndarray:
        known = kept or compared(own)
        weight = np.float32(against)
        return fusion.vote(own.start, opacity, maps.neighbours[own], known, weight)

    def fused(own: slice) -> np.ndarray:
        known = kept or compared(own)
        return fusion.fuse(own.start, maps.inverse, opacity, maps.neighbours[own], known)

    for _ in range(rounds):
        opacity = np.concatenate([voted(own) for own in rows])
    return np.concatenate([fused(own) for own in rows]), opacity
