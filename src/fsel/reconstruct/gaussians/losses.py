"""The training loss of Kerbl et al. 2023, 0.8 L1 + 0.2 (1 - SSIM), with its gradient.

SSIM (Wang et al. 2004) has an 11x11 Gaussian window of sigma 1.5, and zeros beyond the image.
"""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import reordered

SSIM_SHARE = 0.2
REACH = 5  # pixels of the window on each side
SIGMA = 1.5
STABLE = (0.01**2, 0.03**2)


def window(dtype) -> np.ndarray:
    """Return (6,) weights of the pixels 0 to 5 away from the middle; all eleven add to 1."""
    weights = np.exp(-(np.arange(REACH + 1) ** 2) / (2 * SIGMA**2))
    return (weights / (2 * weights.sum() - weights[0])).astype(dtype)


@reordered
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
    kind = image.dtype.type
    height, width = image.shape[1:]
    share = kind(1 / (3 * height * width))
    total = 0.0
    maps = np.empty((5, height, width), image.dtype)
    smooth = np.empty_like(maps)
    padded = np.zeros((height + 2 * REACH, width + 2 * REACH), image.dtype)
    for c in range(3):
        _moments(image[c], truth[c], mask, maps)
        for k in range(5):
            _smooth(maps[k], weights, padded, smooth[k])
        total += SSIM_SHARE * _similarity(smooth, share)
        for k in range(3):
            _smooth(smooth[k], weights, padded, maps[2 + k])
        total += _combine(maps, share, gradient[c])
    if len(mask):
        for c in range(3):
            for y in range(height):
                for x in range(width):
                    gradient[c, y, x] = gradient[c, y, x] if mask[y, x] else kind(0)
    return total


@reordered
def _moments(image, truth, mask, maps):
    """Fill the image, the truth, both squares and the product."""
    grey, none, masked = image.dtype.type(1 / 255), image.dtype.type(0), len(mask) > 0
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            hidden = masked and not mask[y, x]
            a, b = none if hidden else image[y, x], none if hidden else truth[y, x] * grey
            maps[0, y, x], maps[1, y, x] = a, b
            maps[2, y, x], maps[3, y, x], maps[4, y, x] = a * a, b * b, a * b


@reordered
def _smooth(source, weights, padded, out):
    """Convolve with the window; `padded` has zeros along its sides, and stays so."""
    height, width = source.shape
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for y in range(height):
        line = padded[y + REACH]
        for x in range(width):
            line[x + REACH] = source[y, x]
    for y in range(height):
        a, b, c, d, e = padded[y], padded[y + 1], padded[y + 2], padded[y + 3], padded[y + 4]
        f, g, h, i, j = padded[y + 6], padded[y + 7], padded[y + 8], padded[y + 9], padded[y + 10]
        middle, line = padded[y + 5], out[y]
        for x in range(width):
            p = x + REACH
            near = w0 * middle[p] + w1 * (e[p] + f[p]) + w2 * (d[p] + g[p])
            line[x] = near + w3 * (c[p] + h[p]) + w4 * (b[p] + i[p]) + w5 * (a[p] + j[p])
    for y in range(height):
        line, made = padded[REACH], out[y]
        for x in range(width):
            line[x + REACH] = made[x]
        for x in range(width):
            near = w0 * line[x + 5] + w1 * (line[x + 4] + line[x + 6])
            near += w2 * (line[x + 3] + line[x + 7]) + w3 * (line[x + 2] + line[x + 8])
            made[x] = near + w4 * (line[x + 1] + line[x + 9]) + w5 * (line[x] + line[x + 10])


@reordered
def _similarity(smooth, share):
    """Sum of share times (1 - SSIM); the first three maps become its gradients with respect to the
    smoothed image, its smoothed square and the smoothed product."""
    kind = smooth.dtype.type
    one, two, c1, c2 = kind(1), kind(2), kind(STABLE[0]), kind(STABLE[1])
    total, scale = 0.0, kind(SSIM_SHARE) * share
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
        total += line
    return total * share


@reordered
def _combine(maps, share, gradient):
    """Fill the gradient of the whole loss; return its L1 part."""
    kind = gradient.dtype.type
    two, slope, none = kind(2), kind(1 - SSIM_SHARE) * share, kind(0)
    total = 0.0
    for y in range(gradient.shape[0]):
        line = none
        for x in range(gradient.shape[1]):
            a, b = maps[0, y, x], maps[1, y, x]
            gap = a - b
            line += abs(gap)
            edge = slope if gap > none else (-slope if gap < none else none)
            gradient[y, x] = edge + maps[2, y, x] + two * a * maps[3, y, x] + b * maps[4, y, x]
        total += line
    return total * slope
