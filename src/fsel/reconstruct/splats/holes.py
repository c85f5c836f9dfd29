"""Rendered views without holes: pixels of little weight take colours from around them."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact, exact_part

F = np.float32

HALF_WEIGHT = F(0.25)  # of the median pixel's weight: below, coarser levels are mixed in


def typical_weight(weights):
    """Return the median of an image's (h, w) weights above zero; 1 where there are none."""
    met = weights[weights > 0]
    if len(met) == 0:
        return F(1)
    middle = len(met) // 2
    met.partition(middle)
    return met[middle] if len(met) % 2 else F(0.5) * (met[:middle].max() + met[middle])


def fill_holes(planes):
    """Return (T, h, w, 3) float32 colours, 0..255, of (T, 4, h, w) weighted sums and weights, mixed
    with coarser levels (pull-push) where weight is below a quarter of the view's typical one."""
    full = HALF_WEIGHT * np.array([typical_weight(view[3]) for view in planes], F)
    levels, count = [planes], len(planes)
    while max(levels[-1].shape[2:]) > 1:
        height, width = levels[-1].shape[2:]
        levels.append(np.empty((count, 4, (height + 1) // 2, (width + 1) // 2), F))
        _halve(*(level.reshape(4 * count, *level.shape[2:]) for level in levels[-2:]))
    color = np.zeros((count, 3, 1, 1), F)
    for level in reversed(levels):
        coarse, color = color, np.empty((count, 3, *level.shape[2:]), F)
        _blend(coarse, level, full, color)
    return color.transpose(0, 2, 3, 1)


@exact
def _halve(planes, half):
    """Fill 2x2 means of (n, h, w), missing pixels of odd sizes counting as empty."""
    height, width = planes.shape[1], planes.shape[2]
    for c in range(len(planes)):
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
    """Fill the coarser (T, 3, ...) colours, enlarged, under the level's own by its weight."""
    height, width = planes.shape[2], planes.shape[3]
    rows, columns = coarse.shape[2], coarse.shape[3]
    between, own, unit = np.empty(columns, F), np.empty(width, F), np.empty(width, F)
    for t in range(len(planes)):
        for y in range(height):
            v = min(max((F(y) - F(0.5)) * F(0.5), F(0)), F(rows - 1))
            top = int(v)
            bottom, fv = min(top + 1, rows - 1), v - F(top)
            for x in range(width):
                weight = planes[t, 3, y, x]
                own[x] = min(weight / full[t], F(1)) if weight > 0 else F(0)
                unit[x] = F(1) / weight if weight > 0 else F(0)
            for c in range(3):
                line, level = color[t, c, y], planes[t, c, y]
                for i in range(columns):
                    upper, lower = coarse[t, c, top, i], coarse[t, c, bottom, i]
                    between[i] = upper * (F(1) - fv) + lower * fv
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
