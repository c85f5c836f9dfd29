"""PSNR, SSIM and GMSD in one pass, fast enough for a search.

Squared differences of float32 images are summed in float64. SSIM and GMSD are float32, at twice the
lanes: SSIM changes by less than 1e-5, on views without any texture by 2e-4, GMSD by less than 1e-6.
scikit-image is the oracle for PSNR and SSIM, a plain NumPy twin for GMSD (both in the tests).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fsel.core.compiled import reordered, reordered_part
from fsel.metrics.contract import Metric

F = np.float32
NAMES = ("psnr", "ssim", "gmsd")  # the columns
SSIM_WINDOW = 11
SSIM_SIGMA = 1.5
MARGIN = SSIM_WINDOW // 2  # pixels along the edge around which no whole window fits
_GAUSSIAN = np.exp(-0.5 * (np.arange(-MARGIN, MARGIN + 1) / SSIM_SIGMA) ** 2)
# single weights, W0 in the middle
W5, W4, W3, W2, W1, W0 = (_GAUSSIAN / _GAUSSIAN.sum())[: MARGIN + 1].astype(F)
C1, C2 = F(0.01**2), F(0.03**2)
GMSD_CONSTANT = F(170.0 / 255.0**2)
LUMA = (F(0.299), F(0.587), F(0.114))
PSNR_CEILING = 100.0  # dB, for identical images


def score(rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None) -> np.ndarray:
    """Compute PSNR, SSIM and GMSD of every view, or of the part of it inside a mask.

    PSNR is over all channels, in dB, at most 100. SSIM (Wang et al. 2004) has a Gaussian window of
    1.5 pixels in 11x11, K1 = 0.01, K2 = 0.03 and population covariances, over the pixels with a
    whole window, averaged over channels, as in `pytorch-msssim`. GMSD (Xue et al. 2014; lower is
    better) is the standard deviation of the gradient similarity of the luma halved in size, over
    the pixels with a whole 3x3 neighbourhood.

    With masks nothing outside them counts: there the rendering is taken to be the truth. PSNR is
    over the mask's pixels, SSIM over the windows whose middle lies in the mask, GMSD over the
    halved pixels that touch it.

    Args:
        rendered: (T, h, w, 3) float32 in [0, 1].
        truth: (T, h, w, 3) uint8.
        masks: (T, h, w) bool, or None for all pixels.

    Returns:
        (T, 3) float64, columns as `NAMES`.

    Raises:
        ValueError: as `fsel.metrics.score_views`.
    """
    if rendered.shape != truth.shape or min(rendered.shape[1:3]) < SSIM_WINDOW:
        raise ValueError(
            f"views of equal size, at least {SSIM_WINDOW}x{SSIM_WINDOW}, expected: "
            f"{rendered.shape} against {truth.shape}"
        )
    if masks is None:
        masks = np.ones(truth.shape[:3], bool)
    if masks.shape != truth.shape[:3]:
        raise ValueError(f"masks must be {truth.shape[:3]}, got {masks.shape}")
    if len(empty := np.flatnonzero(inside(masks) == 0)):
        raise ValueError(
            f"the mask of view {empty[0]} has no pixel {MARGIN} or more from the image's edge: "
            "nothing to compare. Hint: score views that show the object"
        )
    images = np.ascontiguousarray(rendered, np.float32), np.ascontiguousarray(truth)
    scored = [_score(*view) for view in zip(*images, np.ascontiguousarray(masks), strict=True)]
    return np.array(scored, np.float64).reshape(len(scored), len(NAMES))


def inside(masks: np.ndarray) -> np.ndarray:
    """Return (T,) share of the pixels with a whole window around them that (T, h, w) masks hold."""
    return masks[:, MARGIN:-MARGIN, MARGIN:-MARGIN].mean(axis=(1, 2))


def _score(rendered: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> tuple[float, float, float]:
    """Return PSNR, SSIM and GMSD of one view."""
    height, width = mask.shape
    luma, similarity = np.zeros((2, height, width), F), 0.0
    channels = np.empty((2, 3, height * width), F)
    error = _separate(rendered, truth, mask, channels, luma) / (3 * np.count_nonzero(mask))
    counted = np.zeros((height, width), F)  # 1 at the first pixel of each whole window
    counted[: -2 * MARGIN, : -2 * MARGIN] = mask[MARGIN:-MARGIN, MARGIN:-MARGIN]
    for first, second in zip(*channels, strict=True):
        similarity += _ssim(first, second, counted.ravel(), 1, width)
    psnr = min(-10 * math.log10(error), PSNR_CEILING) if error > 0 else PSNR_CEILING
    return psnr, similarity / (3 * np.count_nonzero(counted)), _gmsd(*luma, mask)


@reordered
def _separate(rendered, truth, mask, channels, luma):
    """Fill (2, 3, h * w) channels and (2, h, w) luma of a view, by which nothing outside the mask
    differs, and its truth; return the summed squares of their differences."""
    error = 0.0
    height, width = mask.shape
    for c in range(3):
        gain, first, second = LUMA[c], channels[0, c], channels[1, c]
        for y in range(height):
            for x in range(width):
                b = F(truth[y, x, c]) / F(255)
                a = rendered[y, x, c] if mask[y, x] else b
                first[y * width + x], second[y * width + x] = a, b
            for x in range(width):
                a, b = first[y * width + x], second[y * width + x]
                gap = np.float64(a - b)
                error += gap * gap
                luma[0, y, x] += gain * a
                luma[1, y, x] += gain * b
    return error


@reordered
def _ssim(first, second, counted, step, width):
    """Return the sum of SSIM over the windows of one channel that count: `counted` is 1 at their
    first pixels, so none reaches across the end of a row of `width`; pixels are a `step` apart."""
    across = np.empty((4, len(first) - 2 * MARGIN), F)
    down = np.empty((4, across.shape[1] - 2 * MARGIN * width), F)
    field = np.empty(len(first), F)
    _weigh(first, step, across[0])
    _weigh(second, step, across[1])
    for i in range(len(first)):
        field[i] = first[i] * first[i] + second[i] * second[i]
    _weigh(field, step, across[2])
    for i in range(len(first)):
        field[i] = first[i] * second[i]
    _weigh(field, step, across[3])
    for kind in range(4):
        _weigh(across[kind], width, down[kind])
    total = 0.0
    for start in range(0, down.shape[1], width):  # in float32 along a row, float64 over rows
        part = F(0)
        for i in range(start, min(start + width, down.shape[1])):
            a, b = down[0, i], down[1, i]
            squares, product = a * a + b * b, a * b
            value = ((F(2) * product + C1) * (F(2) * (down[3, i] - product) + C2)) / (
                (squares + C1) * (down[2, i] - squares + C2)
            )
            part += value * counted[i]
        total += np.float64(part)
    return total


@reordered_part
def _weigh(line, step, out):
    """The Gaussian over eleven entries that lie a step apart; slices, as they vectorise."""
    l0, l1, l2, l3, l4 = line, line[step:], line[2 * step :], line[3 * step :], line[4 * step :]
    l5, l6, l7 = line[5 * step :], line[6 * step :], line[7 * step :]
    l8, l9, l10 = line[8 * step :], line[9 * step :], line[10 * step :]
    for i in range(len(out)):
        out[i] = (
            W0 * l5[i]
            + W1 * (l4[i] + l6[i])
            + W2 * (l3[i] + l7[i])
            + W3 * (l2[i] + l8[i])
            + W4 * (l1[i] + l9[i])
            + W5 * (l0[i] + l10[i])
        )


@reordered
def _gmsd(first, second, mask):
    a, b = _gradients(_halved(first)), _gradients(_halved(second))
    total, squares, count = 0.0, 0.0, 0
    for y in range(a.shape[0]):
        for x in range(a.shape[1]):
            v, u = 2 * y + 2, 2 * x + 2
            touched = mask[v, u] | mask[v, u + 1] | mask[v + 1, u] | mask[v + 1, u + 1]
            p, q = a[y, x], b[y, x]
            value = (F(2) * p * q + GMSD_CONSTANT) / (p * p + q * q + GMSD_CONSTANT)
            total += value if touched else 0.0
            squares += value * value if touched else 0.0
            count += touched
    mean = total / count
    return np.sqrt(max(squares / count - mean * mean, 0.0))


@reordered_part
def _halved(image):
    """2x2 means; a last odd row or column is dropped."""
    half = np.empty((image.shape[0] // 2, image.shape[1] // 2), F)
    for y in range(half.shape[0]):
        for x in range(half.shape[1]):
            v, u = 2 * y, 2 * x
            upper, lower = image[v, u] + image[v, u + 1], image[v + 1, u] + image[v + 1, u + 1]
            half[y, x] = F(0.25) * (upper + lower)
    return half


@reordered_part
def _gradients(image):
    """Magnitude of the Prewitt gradient, where a pixel has its whole 3x3 neighbourhood."""
    out = np.empty((image.shape[0] - 2, image.shape[1] - 2), F)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            across, down = F(0), F(0)
            for s in range(3):
                across += image[y + s, x + 2] - image[y + s, x]
                down += image[y + 2, x + s] - image[y, x + s]
            out[y, x] = np.sqrt(across * across + down * down) / F(3)
    return out


def _column(name: str) -> Callable[..., np.ndarray]:
    column = NAMES.index(name)
    return lambda rendered, truth, masks: score(rendered, truth, masks)[:, column]


PSNR = Metric("psnr", "PSNR", True, _column("psnr"), unit="dB", digits=2)
SSIM = Metric("ssim", "SSIM", True, _column("ssim"))
GMSD = Metric("gmsd", "GMSD", False, _column("gmsd"))
