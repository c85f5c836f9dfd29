"""Rendering of pixel-aligned splats: a depth pass, an accumulation pass, and the filling of holes.

float32: positions are relative to a scene whose far plane is some thousand pixels of disparity.
"""

from __future__ import annotations

import numba
import numpy as np

from fsel.reconstruct.splats.simd import add_scaled

F, INT = np.float32, np.int32
U = np.uint64  # unsigned indices: no wrapping to check
_jit = numba.njit(cache=True, fastmath=True, nogil=True, error_model="numpy")

BINS = 24  # of inverse depth in the depth pass
SHARE = F(0.08)  # of the opacity around a pixel that must lie in front of a surface to hide it
HALF_WEIGHT = F(0.25)  # of the median pixel's weight: below, coarser levels are mixed in


@_jit
def render_view(splats, colors, pose, k, width, height, tolerance, near, far):
    """One view of a cloud of splats.

    The depth pass gathers opacity in bins of inverse depth over 3x3 pixels; the visible surface is
    the first with a fair share of it, so that a single floater hides nothing. The accumulation pass
    spreads each splat bilinearly over 2x2 pixels, weighed by its opacity alone (weights that favour
    near sources let a floater beside its own camera outweigh a surface: 0.9 dB less), and drops
    what lies behind the surface.

    Args:
        splats: (5, n) float32: rows of world x, y, z, opacity, depth in the source camera.
        colors: (n, 4) float32, colours in 0..255 and a one.
        pose: (3, 4) float32 world to camera.
        k: (4,) float32 intrinsics, pixels.
        width: pixels.
        height: pixels.
        tolerance: relative depth behind the surface that still counts as the surface.
        near: depth of the first bin, world units.
        far: depth of the last.

    Returns:
        (height, width, 4) float32: weighted colour sums, and weights.
    """
    low = F(1) / far
    scale = F(BINS) / (F(1) / near - low)
    where, cells = _project(splats, pose, k, (width, height), (low, scale))
    index = _inside(cells)
    mass = np.zeros((height + 2) * BINS * (width + 2), F)
    for i in index:
        mass[cells[i]] += splats[3, i]
    mass = mass.reshape(height + 2, BINS, width + 2)
    reach = _reach(mass, (low, scale), tolerance)
    return _accumulate(where, splats[3], index, colors, reach)


@_jit
def _project(splats, pose, k, size, bins):
    """Where splats fall: (n,) pixel coordinates, padded and shifted, and inverse depths; and cells
    of the depth pass, -1 outside. No branches: it vectorises.

    Half a pixel beyond the padding's one, so that a coordinate's floor is the corner of the 2x2
    footprint.
    """
    n = splats.shape[1]
    across, down, closeness = np.empty(n, F), np.empty(n, F), np.empty(n, F)
    cells = np.empty(n, INT)
    (width, height), (low, scale) = size, bins
    limit_x, limit_y, row = F(width + 1), F(height + 1), INT(width + 2)
    for i in range(n):
        x, y, z = splats[0, i], splats[1, i], splats[2, i]
        depth = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
        w = F(1) / max(depth, F(1e-9))
        u = k[0] * (pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3])
        v = k[1] * (pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3])
        u, v = u * w + k[2] + F(0.5), v * w + k[3] + F(0.5)
        across[i], down[i], closeness[i] = u, v, w
        inside = (u >= 0) & (v >= 0) & (u < limit_x) & (v < limit_y) & (w <= F(1e6))
        bin_ = INT(BINS - 1) - INT(min(max((w - low) * scale, F(0)), F(BINS - 1)))
        column = INT(min(max(u, F(0)), limit_x) + F(0.5))
        line = INT(min(max(v, F(0)), limit_y) + F(0.5))
        cells[i] = (line * INT(BINS) + bin_) * row + column if inside else INT(-1)
    return (across, down, closeness), cells


@_jit
def _inside(cells):
    """Indices of the cells that are none of -1; always written, kept by a sum: no branches."""
    index, kept = np.empty(len(cells) + 1, INT), 0
    for i in range(len(cells)):
        index[kept] = i
        kept += cells[i] >= 0
    return index[:kept]


@_jit
def _reach(mass, bins, tolerance):
    """Least inverse depth that counts at each pixel, 0 on the padding.

    The surface is the first bin by which SHARE of the opacity in 3x3 pixels has been met. All
    loops run along rows of pixels: they vectorise.

    Args:
        mass: (h + 2, BINS, w + 2) opacity, nearest bin first.
        bins: inverse depth of the farthest bin, and bins for each unit of inverse depth.
        tolerance: as in `render_view`.
    """
    height, width = mass.shape[0] - 2, mass.shape[2] - 2
    reach = np.zeros((height + 2, width + 2), F)
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
    return reach


@_jit
def _accumulate(where, weights, index, colors, reach):
    """Colours and weights of what is no farther than `reach`, an inverse depth, over 2x2 pixels."""
    across, down, closeness = where
    height, width = reach.shape
    limit, flat, row = reach.reshape(height * width), colors.reshape(colors.size), U(width)
    total = np.zeros(4 * height * width, F)
    for i in index:
        left, top = INT(across[i]), INT(down[i])
        fu, fv = across[i] - F(left), down[i] - F(top)
        a = U(top) * row + U(left)
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
    return total.reshape(height, width, 4)[1:-1, 1:-1]


@_jit
def typical_weight(total):
    """Median weight of the pixels that any splat falls on; 1 where there are none.

    Args:
        total: (h, w, 4) float32 weighted colour sums and weights.
    """
    met, count = np.empty(total.shape[0] * total.shape[1], F), 0
    for y in range(total.shape[0]):
        for x in range(total.shape[1]):
            met[count] = total[y, x, 3]
            count += total[y, x, 3] > 0
    if count == 0:
        return F(1)
    met = met[:count]
    low = _ranked(met, (count - 1) // 2)
    upto, high = 0, F(np.finfo(np.float32).max)
    for weight in met:
        upto += weight <= low
        high = min(high, weight if weight > low else high)
    return low if upto > count // 2 else F(0.5) * (low + high)


@_jit
def _ranked(values, rank):
    """Value of a rank, from 0, of positive float32, whose bits, as integers, have their order:
    found from histograms of the first 12 bits, of the next 12, and of the last 8."""
    bits = values.view(np.uint32)
    histogram = np.empty(1 << 12, INT)
    prefix, shift = np.uint32(0), np.uint32(32)
    while shift > 0:
        above, shift = shift, np.uint32(max(INT(shift) - 12, 0))
        for b in range(1 << 12):
            histogram[b] = 0
        for value in bits:
            # a shift by 32 is not defined, and nothing lies above the first bits
            if above == 32 or value >> above == prefix >> above:
                histogram[(value >> shift) & np.uint32(0xFFF)] += 1
        bin_ = 0
        while histogram[bin_] <= rank:
            rank -= histogram[bin_]
            bin_ += 1
        prefix |= np.uint32(bin_) << shift
    return np.array([prefix]).view(np.float32)[0]


@_jit
def fill_holes(total, typical):
    """Colours from weighted sums, pixels of little weight being mixed with coarser levels
    (pull-push).

    Args:
        total: (h, w, 4) float32 weighted colour sums and weights.
        typical: weight of an ordinary pixel; below a quarter of it a pixel is mixed.

    Returns:
        (h, w, 3) float32, 0..255; black where no level holds anything.
    """
    height, width = total.shape[:2]
    planes = np.empty((4, height, width), F)
    for y in range(height):
        for x in range(width):
            for c in range(4):
                planes[c, y, x] = total[y, x, c]
    levels = [planes]
    while max(levels[-1].shape[1:]) > 1:
        levels.append(_halved(levels[-1]))
    color = np.zeros((3, 1, 1), F)
    for i in range(len(levels)):
        color = _blended(color, levels[len(levels) - 1 - i], HALF_WEIGHT * typical)
    filled = np.empty((height, width, 3), F)
    for y in range(height):
        for x in range(width):
            for c in range(3):
                filled[y, x, c] = color[c, y, x]
    return filled


@_jit
def _halved(planes):
    """2x2 means of (4, h, w), missing pixels of odd sizes counting as empty."""
    height, width = planes.shape[1:]
    half = np.empty((4, (height + 1) // 2, (width + 1) // 2), F)
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
    return half


@_jit
def _blended(coarse, planes, full):
    """The coarser (3, ...) colours, bilinearly enlarged, under the level's own by its weight."""
    height, width = planes.shape[1:]
    rows, columns = coarse.shape[1:]
    color = np.empty((3, height, width), F)
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
    return color


@_jit
def _widen(short, line):
    """Fill a line of twice the length, or one less, with a line's linear interpolation."""
    width = len(line)
    line[0] = short[0]
    for i in range((width - 1) // 2):
        line[2 * i + 1] = F(0.75) * short[i] + F(0.25) * short[i + 1]
        line[2 * i + 2] = F(0.25) * short[i] + F(0.75) * short[i + 1]
    if width % 2 == 0:
        line[width - 1] = short[len(short) - 1]
