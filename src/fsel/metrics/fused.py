"""PSNR, SSIM and GMSD in one pass, fast enough for a search.

All three are computed in float64 from float32 images; scikit-image is the oracle for PSNR and SSIM,
a plain NumPy twin for GMSD (both in the tests).
"""

from __future__ import annotations

import numba
import numpy as np

NAMES = ("psnr", "ssim", "gmsd")  # the columns
SSIM_WINDOW = 7
MARGIN = SSIM_WINDOW // 2  # pixels along the edge around which no whole window fits
GMSD_CONSTANT = 170.0 / 255.0**2
PSNR_CEILING = 100.0  # dB, for identical images

# sums may be taken in any order, or they would not vectorise
_jit = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"})


def score(rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None) -> np.ndarray:
    """PSNR, SSIM and GMSD of every view, or of the part of it inside a mask.

    PSNR is over all channels, in dB, at most 100. SSIM (Wang et al. 2004) uses the uniform 7x7
    window with sample covariances, scikit-image's default, averaged over channels. GMSD (Xue et
    al. 2014; lower is better) is the standard deviation of the gradient similarity of the luma
    halved in size, over the pixels with a whole 3x3 neighbourhood.

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
        ValueError: when shapes differ, the images are smaller than 8x8, or a mask has no pixel
            with a whole window around it.
    """
    if rendered.shape != truth.shape or min(rendered.shape[1:3]) < 8:
        raise ValueError(
            f"views of equal size, at least 8x8, expected: {rendered.shape} against {truth.shape}"
        )
    if masks is None:
        masks = np.ones(truth.shape[:3], bool)
    else:
        _check_masks(masks, truth.shape[:3])
    return _score(
        np.ascontiguousarray(rendered, np.float32),
        np.ascontiguousarray(truth),
        np.ascontiguousarray(masks),
    )


def _check_masks(masks: np.ndarray, shape: tuple[int, ...]) -> None:
    if masks.shape != shape:
        raise ValueError(f"masks must be {shape}, got {masks.shape}")
    for t in np.flatnonzero(inside(masks) == 0)[:1]:
        raise ValueError(
            f"the mask of view {t} has no pixel {MARGIN} or more from the image's edge: nothing to "
            "compare. Hint: score views that show the object"
        )


def inside(masks: np.ndarray) -> np.ndarray:
    """(T,) share of the pixels with a whole window around them that (T, h, w) masks hold."""
    return masks[:, MARGIN:-MARGIN, MARGIN:-MARGIN].mean(axis=(1, 2))


@_jit
def _score(rendered, truth, masks):
    out = np.empty((len(rendered), 3))
    height, width = rendered.shape[1:3]
    first, second = np.empty((height, width)), np.empty((height, width))
    for t in range(len(rendered)):
        mask = masks[t]
        error, similarity = 0.0, 0.0
        luma_first, luma_second = np.zeros((height, width)), np.zeros((height, width))
        for c in range(3):
            gain = 0.299 if c == 0 else (0.587 if c == 1 else 0.114)
            for y in range(height):
                for x in range(width):
                    b = truth[t, y, x, c] / 255.0
                    a = np.float64(rendered[t, y, x, c]) if mask[y, x] else b
                    first[y, x], second[y, x] = a, b
                    error += (a - b) * (a - b)
                    luma_first[y, x] += gain * a
                    luma_second[y, x] += gain * b
            similarity += _ssim(first, second, mask)
        error /= 3 * mask.sum()
        out[t, 0] = min(-10.0 * np.log10(error), PSNR_CEILING) if error > 0 else PSNR_CEILING
        out[t, 1] = similarity / 3
        out[t, 2] = _gmsd(luma_first, luma_second, mask)
    return out


@_jit
def _ssim(first, second, mask):
    """Mean SSIM of one channel: running sums of columns, then sums of seven of them."""
    height, width = first.shape
    columns = np.zeros((5, width))
    total, windows = 0.0, 0
    for y in range(height):
        _add_row(columns, first[y], second[y], 1.0)
        if y >= SSIM_WINDOW:
            _add_row(columns, first[y - SSIM_WINDOW], second[y - SSIM_WINDOW], -1.0)
        if y >= SSIM_WINDOW - 1:
            middles = mask[y - MARGIN, MARGIN : width - MARGIN]
            total += _ssim_row(columns, middles)
            windows += middles.sum()
    return total / windows


@_jit
def _add_row(columns, first, second, sign):
    """Add a row of pixels to the sums of both, their squares and their product, or take it away."""
    for x in range(columns.shape[1]):
        a, b = first[x], second[x]
        columns[0, x] += sign * a
        columns[1, x] += sign * b
        columns[2, x] += sign * a * a
        columns[3, x] += sign * b * b
        columns[4, x] += sign * a * b


@_jit
def _ssim_row(columns, middles):
    """Sum over one row of windows, of those whose middle counts."""
    count = SSIM_WINDOW * SSIM_WINDOW
    unbiased = count / (count - 1.0)
    total = 0.0
    for x in range(len(middles)):
        a, b, aa, bb, ab = 0.0, 0.0, 0.0, 0.0, 0.0
        for s in range(SSIM_WINDOW):
            a += columns[0, x + s]
            b += columns[1, x + s]
            aa += columns[2, x + s]
            bb += columns[3, x + s]
            ab += columns[4, x + s]
        a, b = a / count, b / count
        va, vb = unbiased * (aa / count - a * a), unbiased * (bb / count - b * b)
        cov = unbiased * (ab / count - a * b)
        value = ((2 * a * b + 1e-4) * (2 * cov + 9e-4)) / (
            (a * a + b * b + 1e-4) * (va + vb + 9e-4)
        )
        total += value if middles[x] else 0.0
    return total


@_jit
def _gmsd(first, second, mask):
    a, b = _gradients(_halved(first)), _gradients(_halved(second))
    total, squares, count = 0.0, 0.0, 0
    for y in range(a.shape[0]):
        for x in range(a.shape[1]):
            v, u = 2 * y + 2, 2 * x + 2
            touched = mask[v, u] | mask[v, u + 1] | mask[v + 1, u] | mask[v + 1, u + 1]
            p, q = a[y, x], b[y, x]
            value = (2 * p * q + GMSD_CONSTANT) / (p * p + q * q + GMSD_CONSTANT)
            total += value if touched else 0.0
            squares += value * value if touched else 0.0
            count += touched
    mean = total / count
    return np.sqrt(max(squares / count - mean * mean, 0.0))


@_jit
def _halved(image):
    """2x2 means; a last odd row or column is dropped."""
    half = np.empty((image.shape[0] // 2, image.shape[1] // 2))
    for y in range(half.shape[0]):
        for x in range(half.shape[1]):
            v, u = 2 * y, 2 * x
            half[y, x] = (image[v, u] + image[v, u + 1] + image[v + 1, u] + image[v + 1, u + 1]) / 4
    return half


@_jit
def _gradients(image):
    """Magnitude of the Prewitt gradient, where a pixel has its whole 3x3 neighbourhood."""
    out = np.empty((image.shape[0] - 2, image.shape[1] - 2))
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            across, down = 0.0, 0.0
            for s in range(3):
                across += image[y + s, x + 2] - image[y + s, x]
                down += image[y + 2, x + s] - image[y, x + s]
            out[y, x] = np.sqrt(across * across + down * down) / 3.0
    return out
