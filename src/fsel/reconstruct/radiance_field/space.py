"""The space of the field: a contraction of all of space into a cube, and steps through it.

Inside the cube of half-side 1 nothing changes; a point at largest coordinate r > 1 moves to 2 - 1/r
along its direction from the middle (Barron et al. 2022, with the largest coordinate as the norm,
so that the image of space is the cube of half-side 2).
"""

from __future__ import annotations

import math

from fsel.core.compiled import exact

HALF_SIDE = 2.0  # of the cube that all of space is contracted into


@exact
def shrink(r):
    """Factor by which a point at largest coordinate r moves towards the middle."""
    if r <= 1.0:
        return 1.0
    inverse = 1.0 / r
    return (2.0 - inverse) * inverse


@exact
def pace(x, y, z, dx, dy, dz):
    """Contracted length that a ray passes at a point for each unit of its own length."""
    ax, ay, az = abs(x), abs(y), abs(z)
    r = max(ax, ay, az)
    if r <= 1.0:
        return 1.0
    if ax == r:
        outward, a, da, b, db = math.copysign(dx, dx * x), y, dy, z, dz
    elif ay == r:
        outward, a, da, b, db = math.copysign(dy, dy * y), x, dx, z, dz
    else:
        outward, a, da, b, db = math.copysign(dz, dz * z), x, dx, y, dy
    inverse = 1.0 / r
    factor = (2.0 - inverse) * inverse
    change = 2.0 * (inverse - 1.0) * inverse * inverse * outward
    u, v = da * factor + a * change, db * factor + b * change
    along = outward * inverse * inverse
    return math.sqrt(along * along + u * u + v * v)
