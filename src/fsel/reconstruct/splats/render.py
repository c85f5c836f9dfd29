"""Rendering of pixel-aligned splats in float32: a depth pass, and an accumulation pass."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.reconstruct.lanes import add_scaled

F, INT = np.float32, np.int32
U, U32 = np.uint64, np.uint32  # unsigned indices: no wrapping to check

BINS = 24  # of inverse depth in the depth pass
TOGETHER = 16  # views whose holes are filled at once
SHARE = F(0.08)  # of the opacity around a pixel that must lie in front of a surface to hide it
HALF_WEIGHT = F(0.25)  # of the median pixel's weight: below, coarser levels are mixed in


def render_views(splats, colors, poses, ks, size, tolerance, depths):
    """Return (T, height, width, 3) float32 views in 0..1 of a cloud of splats, holes filled.

    Args:
        splats: (5, n) float32: rows of world x, y, z, opacity, depth in the source camera.
        colors: (n, 3) float32, 0..255.
        poses: (T, 3, 4) float32 world to camera.
        ks: (T, 4) float32 intrinsics, pixels.
        size: width and height, pixels.
        tolerance: relative depth behind the surface that still counts as the surface, float32.
        depths: of the first bin and of the last, world units, float32.
    """
    width, height = size
    out = np.empty((len(poses), height, width, 3), F)
    room = make_room(splats.shape[1], size)
    painted = np.ones((len(colors), 4), F)
    painted[:, :3] = colors
    for first in range(0, len(out), TOGETHER):
        images = out[first : first + TOGETHER]
        planes = np.empty((len(images), 4, height, width), F)
        for t, plane in enumerate(planes, first):
            total = render_view(splats, painted, poses[t], ks[t], size, tolerance, depths, room)
            plane[:] = total.transpose(2, 0, 1)
        np.divide(fill_holes(planes), F(255), out=images)
    return np.clip(out, F(0), F(1), out=out)


def make_room(n, size):
    """Return arrays that every view of n splats uses anew: see `_project` and `_reach`."""
    width, height = size
    cells, corners, index = np.empty(n, INT), np.empty(n, INT), np.empty(n + 1, INT)
    mass = np.empty((height + 2, BINS, width + 2), F)
    return np.empty((3, n), F), cells, corners, index, mass


def render_view(splats, colors, pose, k, size, tolerance, depths, room):
    """Return (height, width, 4) float32 weighted colour sums, and weights, of one view.

    The depth pass gathers opacity in bins of inverse depth over 3x3 pixels; the visible surface is
    the first with a fair share of it, so that a single floater hides nothing. The accumulation pass
    spreads each splat bilinearly over 2x2 pixels, by its opacity, and drops what lies behind.

    Args:
        splats, size, tolerance, depths: as in `render_views`.
        colors: (n, 4) float32, colours in 0..255 and a one.
        pose: (3, 4) float32 world to camera.
        k: (4,) float32 intrinsics, pixels.
        room: see `make_room`.
    """
    where, cells, corners, index, mass = room
    low = F(1) / depths[1]
    bins = low, F(BINS) / (F(1) / depths[0] - low)
    _project(splats, pose, k, size, bins, where, cells, corners)
    index = index[: _gather(cells, splats[3], index, mass.ravel())]
    reach = np.zeros((size[1] + 2, size[0] + 2), F)
    _reach(mass, bins, tolerance, reach)
    index = index[: _in_front(where[2], corners, reach, index)]
    total = np.zeros((*reach.shape, 4), F)
    flat = colors.ravel(), reach.ravel(), total.ravel()
    _accumulate(where, corners, splats[3], index, U(reach.shape[1]), *flat)
    return total[1:-1, 1:-1]


@exact
def _project(splats, pose, k, size, bins, where, cells, corners):
    """Fill where splats fall, without branches: (3, n) pixel coordinates, padded by one and a half,
    and inverse depths, (n,) cells of the depth pass, -1 outside, and (n,) first padded pixels of
    the 2x2 covered."""
    across, down, closeness = where[0], where[1], where[2]
    (width, height), (low, scale) = size, bins
    limit_x, limit_y, row = F(width + 1), F(height + 1), INT(width + 2)
    for i in range(len(cells)):
        x, y, z = splats[0, i], splats[1, i], splats[2, i]
        depth = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
        w = F(1) / max(depth, F(1e-9))
        u = k[0] * (pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3])
        v = k[1] * (pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3])
        u, v = u * w + k[2] + F(0.5), v * w + k[3] + F(0.5)
        across[i], down[i], closeness[i] = u, v, w
        inside = (u >= 0) & (v >= 0) & (u < limit_x) & (v < limit_y) & (w <= F(1e6))
        bin_ = INT(BINS - 1) - INT(min(max((w - low) * scale, F(0)), F(BINS - 1)))
        u, v = min(max(u, F(0)), limit_x), min(max(v, F(0)), limit_y)
        column, line = INT(u + F(0.5)), INT(v + F(0.5))
        corners[i] = INT(v) * row + INT(u)
        cells[i] = (line * INT(BINS) + bin_) * row + column if inside else INT(-1)


@exact
def _gather(cells, opacity, index, mass):
    """Fill `index` with the splats whose cell is not -1, without branches, and the cells' `mass`
    with their opacities; return the number of these splats."""
    kept = U(0)
    for i in range(len(cells)):
        index[kept] = i
        kept += U(cells[i] >= 0)
    for cell in range(len(mass)):
        mass[cell] = F(0)
    for n in range(kept):
        i = index[n]
        mass[cells[i]] += opacity[i]
    return np.int64(kept)


@exact
def _reach(mass, bins, tolerance, reach):
    """Fill (h + 2, w + 2) least inverse depths that count at each pixel: of the first bin,
    nearest first, by which SHARE of the (h + 2, BINS, w + 2) opacity in 3x3 pixels has been met."""
    height, width = mass.shape[0] - 2, mass.shape[2] - 2
    columns, window = np.empty((BINS, width + 2), F), np.empty((BINS, width), F)
    missing, behind = np.empty(width, F), np.empty(width, F)
    low, thickness = bins[0], F(1) / bins[1]
    for y in range(height):
        for b in range(BINS):
            for x in range(width + 2):
                columns[b, x] = mass[y, b, x] + mass[y + 1, b, x] + mass[y + 2, b, x]
        for x in range(width):
            missing[x], behind[x] = F(0), F(BINS - 1)
        for b in range(BINS):
            for x in range(width):
                around = columns[b, x] + columns[b, x + 1] + columns[b, x + 2]
                window[b, x] = around
                missing[x] += SHARE * around
        for b in range(BINS - 1):
            for x in range(width):
                missing[x] -= window[b, x]
                behind[x] -= F(1) if missing[x] > 0 else F(0)
        for x in range(width):
            reach[y + 1, x + 1] = (low + behind[x] * thickness) / (F(1) + tolerance)


@exact
def _in_front(closeness, corners, reach, index):
    """Keep the indexed splats that count at any of their four pixels; return their number."""
    height, width = reach.shape
    least, kept = np.empty(height * width, F), U(0)  # the last row and column are never read
    for y in range(height - 1):
        for x in range(width - 1):
            upper, lower = (
                min(reach[y, x], reach[y, x + 1]),
                min(reach[y + 1, x], reach[y + 1, x + 1]),
            )
            least[y * width + x] = min(upper, lower)
    for i in index:
        index[kept] = i
        kept += U(closeness[i] >= least[U32(corners[i])])
    return np.int64(kept)


@exact
def _accumulate(where, corners, weights, index, row, flat, limit, total):
    """Add up colours and weights of what is no farther than the `limit` of its pixel, over 2x2
    pixels; `row` is the length of a row of pixels, and the last three arrays are flat."""
    across, down, closeness = where[0], where[1], where[2]
    for i in index:
        a = U(corners[i])
        fu, fv = across[i] - np.floor(across[i]), down[i] - np.floor(down[i])
        c = a + row
        b, d = a + U(1), c + U(1)
        lower, near, of = weights[i] * fv, closeness[i], U(4) * U(i)
        upper = weights[i] - lower
        in_a = upper * (F(1) - fu) if near >= limit[a] else F(0)
        in_b = upper * fu if near >= limit[b] else F(0)
        in_c = lower * (F(1) - fu) if near >= limit[c] else F(0)
        in_d = lower * fu if near >= limit[d] else F(0)
        add_scaled(total, U(4) * a, in_a, flat, of)
        add_scaled(total, U(4) * b, in_b, flat, of)
        add_scaled(total, U(4) * c, in_c, flat, of)
        add_scaled(total, U(4) * d, in_d, flat, of)


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
