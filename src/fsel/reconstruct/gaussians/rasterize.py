"""Compositing tile by tile, front to back, and its gradients, as in Kerbl et al. 2023.

The gradients also go front to back: what lies behind a Gaussian is the pixel's whole colour less
what was met so far.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact, exact_part, reordered, reordered_part
from fsel.reconstruct.gaussians.projection import LEAST_ALPHA, PEAK, RED, XX, XY, YY, U, V
from fsel.reconstruct.gaussians.tiles import TILE

PIXELS = TILE * TILE
SUMS = 9  # over the pixels of a Gaussian, see `gradients.backward`
LARGEST_ALPHA = 0.99
LEAST_LIGHT = 1e-4  # a pixel is finished when less would pass
FLOOR = math.log(LEAST_ALPHA) - 0.1  # exponents below it are as good as it: the pixel is skipped
CHECKED = 8  # Gaussians between two looks at whether a tile is finished

# 2^f for f from -1/2 to 1/2, to 8e-8 of the value
POWERS = tuple(
    np.float32(c) for c in (1.00000007, 0.69314695, 0.24022122, 0.05550743, 0.00967546, 0.0013267)
)
BINARY, HALF = np.float32(math.log2(math.e)), np.float32(0.5)


@exact_part
def exponential(x):
    """Compute exp(x) of float32 from -87 to 87, to 1e-6 and in vectors."""
    c0, c1, c2, c3, c4, c5 = POWERS
    y = x * BINARY
    whole = np.floor(y + HALF)
    g = y - whole
    power = ((((c5 * g + c4) * g + c3) * g + c2) * g + c1) * g + c0
    # the exponent's bits of a float32
    return power * np.int32((np.int32(whole) + np.int32(127)) << np.int32(23)).view(np.float32)


def room():
    """Return an array that `composite` and `backward` fill; it begins with the distances in x, then
    in y, of a tile's pixel centres from its corner."""
    y, x = np.indices((TILE, TILE)) + 0.5
    return np.concatenate([x.ravel(), y.ravel(), np.zeros(5 * PIXELS)]).astype(np.float32)


@reordered
def composite(rows, starts, members, room, background, image, rest, first):
    """Render the tiles from the one numbered `first` on.

    Args:
        rows: (v, COLUMNS) projected Gaussians, nearest first.
        starts, members: as `tiles.assign` gives them for these tiles.
        room: as `room` gives it.
        background: (3,) colour behind everything.
        image: (3, h, w), filled.
        rest: (h, w), filled with the light that passes all Gaussians.
    """
    height, width = rest.shape
    across = (width + TILE - 1) // TILE
    # of each pixel: the light that passes (below zero when finished), red, green, blue
    at, state = room[: 2 * PIXELS], room[2 * PIXELS : 6 * PIXELS]
    for t in range(len(starts) - 1):
        left, top = ((first + t) % across) * TILE, ((first + t) // across) * TILE
        wide, high = min(width - left, TILE), min(height - top, TILE)
        _open(state, wide, high)
        for n in range(starts[t], starts[t + 1]):
            if (n - starts[t]) % CHECKED == CHECKED - 1 and _finished(state):
                break
            _add(state, at, rows, members[n], left, top)
        for y in range(high):
            for x in range(wide):
                p = y * TILE + x
                passed = abs(state[p])
                rest[top + y, left + x] = passed
                for c in range(3):
                    color = state[(1 + c) * PIXELS + p]
                    image[c, top + y, left + x] = color + background[c] * passed


@reordered_part
def _open(state, wide, high):
    """Start a tile; pixels beyond the image are finished."""
    for p in range(PIXELS):
        state[p] = 1 if p % TILE < wide and p // TILE < high else -1
        for c in range(1, len(state) // PIXELS):
            state[c * PIXELS + p] = 0


@reordered_part
def _finished(state):
    light = state[0]
    for p in range(1, PIXELS):
        light = max(light, state[p])
    return light < 0


@exact_part
def _raw_alpha(dx, dy, xx, xy, yy, peak, floor):
    """Return the opacity of a Gaussian at a pixel, which both passes compare: it rounds alike."""
    return exponential(max(peak + (xx * dx + xy * dy) * dx + yy * dy * dy, floor))


@exact_part
def _passed(light, alpha):
    """Return the light that passes an opacity, which both passes compare: it rounds alike."""
    return light - light * alpha


@reordered_part
def _add(state, at, rows, i, left, top):
    """Add one Gaussian to one tile."""
    kind = rows.dtype.type
    none, most, least = kind(0), kind(LARGEST_ALPHA), kind(LEAST_LIGHT)
    floor, faintest = kind(FLOOR), kind(LEAST_ALPHA)
    u, v = rows[i, U] - kind(left), rows[i, V] - kind(top)
    xx, xy, yy, peak = rows[i, XX], rows[i, XY], rows[i, YY], rows[i, PEAK]
    red, green, blue = rows[i, RED], rows[i, RED + 1], rows[i, RED + 2]
    for p in range(PIXELS):
        dx, dy = at[p] - u, at[PIXELS + p] - v
        alpha = min(_raw_alpha(dx, dy, xx, xy, yy, peak, floor), most)
        alpha = alpha if alpha >= faintest else none
        light = state[p]
        after = _passed(light, alpha)
        goes = after >= least
        weight = alpha * light if goes else none
        state[p] = after if goes else -abs(light)
        state[PIXELS + p] += weight * red
        state[2 * PIXELS + p] += weight * green
        state[3 * PIXELS + p] += weight * blue


@reordered
def backward(rows, starts, members, room, image, slope, ends, sums, apart, first, last):
    """Carry the gradient of tiles `first` to `last` back to the Gaussians, summed over pixels.

    Args:
        rows, starts, members, room: as in `composite`.
        image: (3, h, w) as `composite` filled it.
        slope: (3, h, w) gradient with respect to it.
        ends: (tiles,) int64, filled: where the `members` end that any pixel of a tile shows.
        sums: (v, SUMS) zeros, filled: see `gradients.backward`.
        apart: whether `sums` has a row for each of `members` instead, which `add_up` adds up.
    """
    height, width = image.shape[1:]
    across = (width + TILE - 1) // TILE
    # of each pixel: the light that passes, what lies behind times its gradient, the gradient
    at, state = room[: 2 * PIXELS], room[2 * PIXELS :]
    for t in range(first, last):
        left, top = (t % across) * TILE, (t // across) * TILE
        wide, high = min(width - left, TILE), min(height - top, TILE)
        _open(state, wide, high)
        for y in range(high):
            for x in range(wide):
                p, behind = y * TILE + x, rows.dtype.type(0)
                for c in range(3):
                    gradient = slope[c, top + y, left + x]
                    state[(2 + c) * PIXELS + p] = gradient
                    behind += gradient * image[c, top + y, left + x]
                state[PIXELS + p] = behind
        ends[t] = starts[t + 1]
        for n in range(starts[t], starts[t + 1]):
            if (n - starts[t]) % CHECKED == CHECKED - 1 and _finished(state):
                ends[t] = n
                break
            row = n if apart else members[n]
            _add_back(state, at, rows, members[n], left, top, sums, row, apart)


@exact
def add_up(starts, members, ends, parts, sums, first, last):
    """Add the parts of tiles `first` to `last`, tile by tile, to the Gaussians' rows of `sums`."""
    for t in range(first, last):
        for n in range(starts[t], ends[t]):
            i = members[n]
            for k in range(SUMS):
                sums[i, k] += parts[n, k]


@exact_part
def _accumulate(out, row, values, alone):
    """Add to a row, or fill it; as `exact`, each sum over a tile is complete before it is added."""
    for k in range(len(values)):
        out[row, k] = values[k] if alone else out[row, k] + values[k]


@reordered_part
def _add_back(state, at, rows, i, left, top, out, row, alone):
    """Add the gradients of one Gaussian on one tile, with `_add`'s arithmetic."""
    kind = rows.dtype.type
    none, one, most, least = kind(0), kind(1), kind(LARGEST_ALPHA), kind(LEAST_LIGHT)
    floor, faintest = kind(FLOOR), kind(LEAST_ALPHA)
    u, v = rows[i, U] - kind(left), rows[i, V] - kind(top)
    xx, xy, yy, peak = rows[i, XX], rows[i, XY], rows[i, YY], rows[i, PEAK]
    red, green, blue = rows[i, RED], rows[i, RED + 1], rows[i, RED + 2]
    s0, s1, s2, s3, s4, s5, s6, s7, s8 = (none, none, none, none, none, none, none, none, none)
    for p in range(PIXELS):
        dx, dy = at[p] - u, at[PIXELS + p] - v
        raw = _raw_alpha(dx, dy, xx, xy, yy, peak, floor)
        alpha = min(raw, most)
        alpha = alpha if alpha >= faintest else none
        light = state[p]
        after = _passed(light, alpha)
        goes = after >= least
        weight = alpha * light if goes else none
        state[p] = after if goes else -abs(light)
        gr, gg, gb = state[2 * PIXELS + p], state[3 * PIXELS + p], state[4 * PIXELS + p]
        shown = red * gr + green * gg + blue * gb
        behind = state[PIXELS + p] - weight * shown
        state[PIXELS + p] = behind
        s0 += weight * gr
        s1 += weight * gg
        s2 += weight * gb
        # with respect to the exponent; where alpha is clipped it does not move
        moved = weight * shown - behind * alpha / (one - alpha)
        moved = moved if goes and raw < most else none
        s3 += moved
        s4 += moved * dx
        s5 += moved * dy
        s6 += moved * dx * dx
        s7 += moved * dx * dy
        s8 += moved * dy * dy
    _accumulate(out, row, (s0, s1, s2, s3, s4, s5, s6, s7, s8), alone)
