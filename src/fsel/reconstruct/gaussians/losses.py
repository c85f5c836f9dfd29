"""The training loss of Kerbl et al. 2023, 0.8 L1 + 0.2 (1 - SSIM), with its gradient.

SSIM (Wang et al. 2004) has an 11x11 Gaussian window of sigma 1.5, and zeros beyond the image.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.core.compiled import reordered
from fsel.core.threads import ranges, spread

SSIM_SHARE = 0.2
REACH = 5  # pixels of the window on each side
SIGMA = 1.5
STABLE = (0.01**2, 0.03**2)
FEWEST = 24  # lines of a range, which needs ten beyond it on each side


def window() -> np.ndarray:
    """Return (6,) float32 weights of the pixels 0 to 5 from the middle; all eleven add to 1."""
    weights = np.exp(-(np.arange(REACH + 1) ** 2) / (2 * SIGMA**2))
    return (weights / (2 * weights.sum() - weights[0])).astype(np.float32)


def loss_gradient(image, truth, mask, weights, gradient):
    """Return the loss of an image against the truth, a mean over pixels and channels.

    Where the mask is False both are taken to be black, as beyond the image: nothing there counts.

    Args:
        image: (3, h, w).
        truth: (3, h, w) uint8.
        mask: (h, w) bool, or (0, 0) for all pixels.
        weights: as `window` gives them.
        gradient: (3, h, w), filled with the gradient.
    """
    height, width = image.shape[1:]
    share, lines = image.dtype.type(1 / (3 * height * width)), np.empty((2, 3, height), image.dtype)
    given = image, truth, mask, weights, gradient, share, lines
    spread(partial(_differentiate, *given), ranges(height, FEWEST, 1))
    ssim, gaps = lines.sum(axis=(1, 2), dtype=np.float64) / image.size
    return SSIM_SHARE * ssim + (1 - SSIM_SHARE) * gaps


def _differentiate(image, truth, mask, weights, gradient, share, lines, first, last):
    """Fill the gradient of lines `first` to `last`, and the sums of their terms of the loss; twice
    the window's reach beyond them is computed too."""
    height, width = image.shape[1:]
    low, high = max(first - 2 * REACH, 0), min(last + 2 * REACH, height)
    maps = np.empty((5, high - low, width), image.dtype)
    smooth, sums = np.empty_like(maps), np.empty(high - low, image.dtype)
    padded = np.zeros((high - low + 2 * REACH, width + 2 * REACH), image.dtype)
    for c in range(3):
        _moments(image[c], truth[c], mask, maps, low)
        _smooth(maps, weights, padded, smooth)
        _similarity(smooth, share, sums)
        lines[0, c, first:last] = sums[first - low : last - low]
        _smooth(smooth[:3], weights, padded, maps[2:])
        _combine(maps, share, gradient[c], lines[1, c], low, first, last)
    if len(mask):
        gradient[:, first:last][:, ~mask[first:last]] = 0


@reordered
def _moments(image, truth, mask, maps, low):
    """Fill the image, the truth, both squares and the product, from line `low` on."""
    grey, none, masked = image.dtype.type(1 / 255), image.dtype.type(0), len(mask) > 0
    for y in range(maps.shape[1]):
        for x in range(maps.shape[2]):
            hidden = masked and not mask[low + y, x]
            a = none if hidden else image[low + y, x]
            b = none if hidden else truth[low + y, x] * grey
            maps[0, y, x], maps[1, y, x] = a, b
            maps[2, y, x], maps[3, y, x], maps[4, y, x] = a * a, b * b, a * b


@reordered
def _smooth(sources, weights, padded, made):
    """Convolve maps with the window; `padded` has zeros along its sides, and stays so."""
    count, height, width = sources.shape
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for k in range(count):
        source, out = sources[k], made[k]
        for y in range(height):
            line = padded[y + REACH]
            for x in range(width):
                line[x + REACH] = source[y, x]
        for y in range(height):
            a, b, c, d, e = padded[y], padded[y + 1], padded[y + 2], padded[y + 3], padded[y + 4]
            f, g, h, i = padded[y + 6], padded[y + 7], padded[y + 8], padded[y + 9]
            middle, j, line = padded[y + 5], padded[y + 10], out[y]
            for x in range(width):
                p = x + REACH
                near = w0 * middle[p] + w1 * (e[p] + f[p]) + w2 * (d[p] + g[p])
                line[x] = near + w3 * (c[p] + h[p]) + w4 * (b[p] + i[p]) + w5 * (a[p] + j[p])
        for y in range(height):
            line, to = padded[REACH], out[y]
            for x in range(width):
                line[x + REACH] = to[x]
            for x in range(width):
                near = w0 * line[x + 5] + w1 * (line[x + 4] + line[x + 6])
                near += w2 * (line[x + 3] + line[x + 7]) + w3 * (line[x + 2] + line[x + 8])
                to[x] = near + w4 * (line[x + 1] + line[x + 9]) + w5 * (line[x] + line[x + 10])


@reordered
def _similarity(smooth, share, sums):
    """Fill the sum of 1 - SSIM of every line; the first three maps become gradients with respect to
    the smoothed image, its smoothed square and the smoothed product."""
    kind = smooth.dtype.type
    one, two, c1, c2 = kind(1), kind(2), kind(STABLE[0]), kind(STABLE[1])
    scale = kind(SSIM_SHARE) * share
    for y in range(smooth.shape[1]):
        line = kind(0)
        for x in range(smooth.shape[2]):
            a, b = smooth[0, y, x], smooth[1, y, x]
            aa, bb, ab = smooth[2, y, x], smooth[3, y, x], smooth[4, y, x]
            top, spread = two * a * b + c1, two * (ab - a * b) + c2
            under, squares = a * a + b * b + c1, aa - a * a + bb - b * b + c2
            inverse = one / (under * squares)
            value = top * spread * inverse
            line += one - value
            moved = b * (spread - top) * inverse + value * a * (under - squares) * inverse
            smooth[0, y, x] = -scale * two * moved
            smooth[1, y, x] = scale * value / squares
            smooth[2, y, x] = -scale * two * top * inverse
        sums[y] = line


@reordered
def _combine(maps, share, gradient, sums, low, first, last):
    """Fill the gradient of the whole loss, and every line's sum of absolute differences."""
    kind = gradient.dtype.type
    two, slope, none = kind(2), kind(1 - SSIM_SHARE) * share, kind(0)
    for y in range(first, last):
        line, m = none, y - low
        for x in range(gradient.shape[1]):
            a, b = maps[0, m, x], maps[1, m, x]
            gap = a - b
            line += abs(gap)
            edge = slope if gap > none else (-slope if gap < none else none)
            gradient[y, x] = edge + maps[2, m, x] + two * a * maps[3, m, x] + b * maps[4, m, x]
        sums[y] = line
