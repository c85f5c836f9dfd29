"""Rendering of pixel-aligned splats: a depth pass, an accumulation pass, and the filling of holes.

float32: positions are relative to a scene whose far plane is some thousand pixels of disparity.
"""

from __future__ import annotations

import numba
import numpy as np

F = np.float32
U = np.uint64  # unsigned indices: no wrapping to check
_jit = numba.njit(cache=True, fastmath=True, nogil=True)

BINS = 24  # of inverse depth in the depth pass
SHARE = F(0.08)  # of the opacity around a pixel that must lie in front of a surface to hide it
HALF_WEIGHT = F(0.25)  # of the median pixel's weight: below it, a pixel leans on coarser levels


@_jit
def render_view(splats, colors, pose, k, width, height, tolerance, near, far):
    """One view of a cloud of splats.

    The depth pass gathers opacity in bins of inverse depth over 3x3 pixels; the visible surface is
    the first with a fair share of it, so that a lone floater hides nothing. The accumulation pass
    spreads each splat bilinearly over 2x2 pixels, weighed by its opacity alone (weights that favour
    near sources let a floater beside its own camera outweigh a surface: 0.9 dB less), and drops
    what lies behind the surface.

    Args:
        splats: (5, n) float32: rows of world x, y, z, opacity, depth in the source camera.
        colors: (n, 3) float32, 0..255.
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
    across, down, closeness = _project(splats, pose, k)
    mass = np.zeros((height + 2, width + 2, BINS), F)
    low = F(1) / far
    scale = F(BINS) / (F(1) / near - low)
    index = np.empty(splats.shape[1], np.int64)
    kept = 0
    for i in range(splats.shape[1]):
        u, v, w = across[i], down[i], closeness[i]
        inside = (u >= 0) & (v >= 0) & (u < F(width + 1)) & (v < F(height + 1)) & (w <= F(1e6))
        if not inside:
            continue
        index[kept] = i
        kept += 1
        bin_ = BINS - 1 - min(max(int((w - low) * scale), 0), BINS - 1)
        mass[int(v + F(0.5)), int(u + F(0.5)), bin_] += splats[3, i]
    reach = F(1) / (_surface(mass, low, scale) * (F(1) + tolerance))
    return _accumulate((across, down, closeness), splats[3], index[:kept], colors, reach)


@_jit
def _project(splats, pose, k):
    """(n,) pixel coordinates, padded and shifted, and inverse depths; no branches: it vectorises.

    Half a pixel beyond the padding's one, so that a coordinate's floor is the corner of the 2x2
    footprint.
    """
    n = splats.shape[1]
    across, down, closeness = np.empty(n, F), np.empty(n, F), np.empty(n, F)
    for i in range(n):
        x, y, z = splats[0, i], splats[1, i], splats[2, i]
        depth = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
        w = F(1) / max(depth, F(1e-9))
        u = k[0] * (pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3])
        v = k[1] * (pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3])
        across[i] = u * w + k[2] + F(0.5)
        down[i] = v * w + k[3] + F(0.5)
        closeness[i] = w
    return across, down, closeness


@_jit
def _surface(mass, low, scale):
    """Depth of the first bin by which SHARE of the opacity in 3x3 pixels has been met."""
    height, width = mass.shape[0] - 2, mass.shape[1] - 2
    front = np.full((height + 2, width + 2), F(np.finfo(np.float32).max))
    columns = np.zeros((width + 2, BINS), F)
    window = np.empty(BINS, F)
    for y in range(1, height + 1):
        for x in range(width + 2):
            for b in range(BINS):
                columns[x, b] = mass[y - 1, x, b] + mass[y, x, b] + mass[y + 1, x, b]
        for x in range(1, width + 1):
            goal = F(0)
            for b in range(BINS):
                window[b] = columns[x - 1, b] + columns[x, b] + columns[x + 1, b]
                goal += window[b]
            if goal > 0:
                goal *= SHARE
                bin_ = 0
                goal -= window[0]
                while goal > 0 and bin_ < BINS - 1:
                    bin_ += 1
                    goal -= window[bin_]
                front[y, x] = F(1) / (low + F(BINS - 1 - bin_) / scale)
    return front


@_jit
def _accumulate(where, weights, index, colors, reach):
    """Colours and weights of what is no farther than `reach`, an inverse depth, over 2x2 pixels."""
    across, down, closeness = where
    height, width = reach.shape
    limit, row = reach.reshape(height * width), U(width)
    total = np.zeros((height * width, 4), F)
    for i in index:
        left, top = np.int32(across[i]), np.int32(down[i])
        fu, fv = across[i] - F(left), down[i] - F(top)
        a = U(top) * row + U(left)
        c = a + row
        b, d = a + U(1), c + U(1)
        lower, near = weights[i] * fv, closeness[i]
        upper = weights[i] - lower
        in_a = upper * (F(1) - fu) if near >= limit[a] else F(0)
        in_b = upper * fu if near >= limit[b] else F(0)
        in_c = lower * (F(1) - fu) if near >= limit[c] else F(0)
        in_d = lower * fu if near >= limit[d] else F(0)
        for channel in range(4):
            value = colors[i, channel] if channel < 3 else F(1)
            total[a, channel] += in_a * value
            total[b, channel] += in_b * value
            total[c, channel] += in_c * value
            total[d, channel] += in_d * value
    return total.reshape(height, width, 4)[1:-1, 1:-1]


@_jit
def typical_weight(total):
    """Median weight of the pixels that any splat falls on; 1 where there are none.

    Args:
        total: (h, w, 4) float32 weighted colour sums and weights.
    """
    weights = total[:, :, 3].copy().reshape(-1)
    count = 0
    for weight in weights:
        if weight > 0:
            weights[count] = weight
            count += 1
    return F(np.median(weights[:count])) if count > 0 else F(1)


def fill_holes(total, typical):
    """Colours from weighted sums, pixels of little weight leaning on coarser levels (pull-push).

    Args:
        total: (h, w, 4) float32 weighted colour sums and weights.
        typical: weight of an ordinary pixel; below a quarter of it a pixel is mixed.

    Returns:
        (h, w, 3) float32, 0..255; black where no level holds anything.
    """
    levels = [total]
    while max(levels[-1].shape[:2]) > 1:
        levels.append(_halved(levels[-1]))
    color = np.zeros((1, 1, 3), np.float32)
    for level in reversed(levels):
        color = _blended(color, level, HALF_WEIGHT * typical)
    return color


@_jit
def _halved(total):
    """2x2 means, missing pixels of odd sizes counting as empty."""
    height, width = total.shape[:2]
    half = np.zeros(((height + 1) // 2, (width + 1) // 2, 4), F)
    for y in range(height):
        for x in range(width):
            for c in range(4):
                half[y // 2, x // 2, c] += F(0.25) * total[y, x, c]
    return half


@_jit
def _blended(coarse, total, full):
    """The coarser colours, bilinearly enlarged, under the level's own by its weight."""
    height, width = total.shape[:2]
    rows, columns = coarse.shape[:2]
    color = np.empty((height, width, 3), F)
    for y in range(height):
        v = min(max((F(y) - F(0.5)) * F(0.5), F(0)), F(rows - 1))
        top = int(v)
        bottom, fv = min(top + 1, rows - 1), v - F(top)
        for x in range(width):
            u = min(max((F(x) - F(0.5)) * F(0.5), F(0)), F(columns - 1))
            left = int(u)
            right, fu = min(left + 1, columns - 1), u - F(left)
            weight = total[y, x, 3]
            own = min(weight / full, F(1))
            for c in range(3):
                above = coarse[top, left, c] * (F(1) - fu) + coarse[top, right, c] * fu
                below = coarse[bottom, left, c] * (F(1) - fu) + coarse[bottom, right, c] * fu
                under = above * (F(1) - fv) + below * fv
                if weight > 0:
                    under += own * (total[y, x, c] / weight - under)
                color[y, x, c] = under
    return color
