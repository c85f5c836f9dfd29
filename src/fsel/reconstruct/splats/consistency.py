"""Opacity and depth by agreement between the depth maps of a subset, block by block of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.core.threads import ranges, spread
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
    """Return (K, h, w) float32 inverse depths, averaged with those that agree, and opacities, voted
    for in some rounds, from how sure matching is of each pixel, 0..1; see `SplatSettings`.

    Blocks change no bit.
    """
    count, neighbours = maps.neighbours.shape
    each = neighbours * (maps.inverse[0].size + 1) * PAIR_BYTES
    most = max(1, VERDICT_BYTES // each)
    few = max(1, most // len(ranges(count, 1, 1)))
    blocks = [(first, min(first + few, count)) for first in range(0, count, few)]
    rows = ranges(count, 1) if count <= most else blocks

    def compared(first: int, last: int) -> fusion.Verdicts:
        own = slice(first, last)
        there = maps.neighbours[own], maps.rotation[own], maps.translation[own]
        given = first, maps.inverse, maps.rays, *there, maps.ks, maps.tolerance[own]
        return fusion.compare(*given)

    known = dict(zip(rows, spread(compared, rows), strict=True)) if count <= most else {}

    def voted(first: int, last: int) -> np.ndarray:
        verdicts = known.get((first, last)) or compared(first, last)
        given = maps.neighbours[first:last], verdicts, np.float32(against)
        return fusion.vote(first, opacity, *given)

    def fused(first: int, last: int) -> np.ndarray:
        verdicts = known.get((first, last)) or compared(first, last)
        return fusion.fuse(first, maps.inverse, opacity, maps.neighbours[first:last], verdicts)

    for _ in range(rounds):
        opacity = np.concatenate(spread(voted, rows))
    return np.concatenate(spread(fused, rows)), opacity
