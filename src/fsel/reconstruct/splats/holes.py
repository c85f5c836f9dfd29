"""Rendered views without holes: pixels of little weight take colours from around them."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact, exact_part

F = np.float32

HALF_WEIGHT = F(0.25)  # of the median pixel's weight: below, coarser levels are mixed in


def typical_weight(total):
    """Return the median weight of an (h, w, 4) image's pixels with any; 1 where there are none."""
    met = total[..., 3][total[..., 3] > 0]
    if len(met) == 0:
        return F(1)
    middle = len(met) // 2
    met.partition(middle)
    return met[middle] if len(met) % 2 else F(0.5) * (met[:middle].max() + met[middle])


def fill_holes(total, typical):
    """Return (h, w, 3) float32 colours, 0..255, of (h, w, 4) weighted sums and weights, mixed with
    coarser levels (pull-push) where weight is below a quarter of `typical`."""
    levels = [np.ascontiguousarray(total.transpose(2, 0, 1))]
    while max(levels[-1].shape[1:]) > 1:
        height, width = levels[-1].shape[1:]
        levels.append(np.empty((4, (height + 1) // 2, (width + 1) // 2), F))
        _halve(levels[-2], levels[-1])
    color = np.zeros((3, 1, 1), F)
    for planes in reversed(levels):
        coarse, color = color, np.empty((3, *planes.shape[1:]), F)
        _blend(coarse, planes, HALF_WEIGHT * typical, color)
    return color.transpose(1, 2, 0)


@exact
def _halve(planes, half):
    """Fill 2x2 means of (4, h, w), missing pixels of odd sizes counting as empty."""
    height, width = planes.shape[1], planes.shape[2]
    for c in range(4):
        for y in range(half.shape[1]):
            upper = planes[c, 2 * y]
            share = F(0.25) if 2 * y + 1 < height else F(0)
            lower = planes[c, min(2 * y + 1, height - 1)]
            for x in range(width // 2):
                first = F(0.25) * (upper[2 * x] + upper[2 * x + 1])
                half[c, y, x] = first + share * (lower[2 * x] + lower[2 * x + 1])
            if width % 2:
                half[c, y, width // 2] = F(0.25) * upper[width - 1] + share * lower[width - 1]


@exact
def _blend(coarse, planes, full, color):
    """Fill the coarser (3, ...) colours, enlarged, under the level's own by its weight."""
    height, width = planes.shape[1], planes.shape[2]
    rows, columns = coarse.shape[1], coarse.shape[2]
    between, own, unit = np.empty(columns, F), np.empty(width, F), np.empty(width, F)
    for y in range(height):
        v = min(max((F(y) - F(0.5)) * F(0.5), F(0)), F(rows - 1))
        top = int(v)
        bottom, fv = min(top + 1, rows - 1), v - F(top)
        for x in range(width):
            weight = planes[3, y, x]
            own[x] = min(weight / full, F(1)) if weight > 0 else F(0)
            unit[x] = F(1) / weight if weight > 0 else F(0)
        for c in range(3):
            line, level = color[c, y], planes[c, y]
            for i in range(columns):
                between[i] = coarse[c, top, i] * (F(1) - fv) + coarse[c, bottom, i] * fv
            _widen(between, line)
            for x in range(width):
                line[x] += own[x] * (level[x] * unit[x] - line[x])


@exact_part
def _widen(short, line):
    """Fill a line of twice the length, or one less, with a line's linear interpolation."""
    width = len(line)
    line[0] = short[0]
    for i in range((width - 1) // 2):
        line[2 * i + 1] = F(0.75) * short[i] + F(0.25) * short[i + 1]
        line[2 * i + 2] = F(0.25) * short[i] + F(0.75) * short[i + 1]
    if width % 2 == 0:
        line[width - 1] = short[len(short) - 1]
