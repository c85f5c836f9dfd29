"""Image metrics of rendered views against the truth, fast enough for a search.

All three are computed in float64 from float32 images; scikit-image is the oracle for PSNR and SSIM,
a plain NumPy twin for GMSD (both in the tests).
"""

from __future__ import annotations

import numba
import numpy as np

METRICS = ("psnr", "ssim", "gmsd")
HIGHER_IS_BETTER = {"psnr": True, "ssim": True, "gmsd": False}
SSIM_WINDOW = 7
MARGIN = SSIM_WINDOW // 2  # pixels along the edge around which no whole window fits
GMSD_CONSTANT = 170.0 / 255.0**2
PSNR_CEILING = 100.0  # dB, for identical images

_jit = numba.njit(cache=True, nogil=True)


def score_views(
    rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None
) -> np.ndarray:
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
        (T, 3) float64, columns as `METRICS`.

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
    first = np.empty((height, width))
    second = np.empty((height, width))
    for t in range(len(rendered)):
        mask = masks[t]
        count = 3 * mask.sum()
        error = 0.0
        similarity = 0.0
        luma_first = np.zeros((height, width))
        luma_second = np.zeros((height, width))
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
        error /= count
        out[t, 0] = min(-10.0 * np.log10(error), PSNR_CEILING) if error > 0 else PSNR_CEILING
        out[t, 1] = similarity / 3
        out[t, 2] = _gmsd(luma_first, luma_second, mask)
    return out


@_jit
def _ssim(first, second, mask):
    """Mean SSIM of one channel: running column sums, then running window sums."""
    height, width = first.shape
    window = SSIM_WINDOW
    count = window * window
    unbiased = count / (count - 1.0)
    columns = np.zeros((5, width))
    total = 0.0
    windows = 0
    for y in range(height):
        for x in range(width):
            a, b = first[y, x], second[y, x]
            columns[0, x] += a
            columns[1, x] += b
            columns[2, x] += a * a
            columns[3, x] += b * b
            columns[4, x] += a * b
        if y >= window:
            for x in range(width):
                a, b = first[y - window, x], second[y - window, x]
                columns[0, x] -= a
                columns[1, x] -= b
                columns[2, x] -= a * a
                columns[3, x] -= b * b
                columns[4, x] -= a * b
        if y >= window - 1:
            middles = mask[y - window // 2, window // 2 : width - window // 2]
            total += _ssim_row(columns, middles, count, unbiased)
            windows += middles.sum()
    return total / windows


@_jit
def _ssim_row(columns, middles, count, unbiased):
    """Sum over one row of windows, of those whose middle counts."""
    window, width = SSIM_WINDOW, columns.shape[1]
    sums = np.zeros(5)
    total = 0.0
    for x in range(width):
        for s in range(5):
            sums[s] += columns[s, x]
            if x >= window:
                sums[s] -= columns[s, x - window]
        if x >= window - 1 and middles[x - window + 1]:
            ma, mb = sums[0] / count, sums[1] / count
            va = unbiased * (sums[2] / count - ma * ma)
            vb = unbiased * (sums[3] / count - mb * mb)
            cov = unbiased * (sums[4] / count - ma * mb)
            total += ((2 * ma * mb + 1e-4) * (2 * cov + 9e-4)) / (
                (ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4)
            )
    return total


@_jit
def _gmsd(first, second, mask):
    height, width = first.shape[0] // 2, first.shape[1] // 2
    small_first = np.empty((height, width))
    small_second = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            small_first[y, x] = first[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].mean()
            small_second[y, x] = second[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].mean()
    total = 0.0
    squares = 0.0
    count = 0
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            if not mask[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].any():
                continue
            a = _gradient(small_first, y, x)
            b = _gradient(small_second, y, x)
            value = (2 * a * b + GMSD_CONSTANT) / (a * a + b * b + GMSD_CONSTANT)
            total += value
            squares += value * value
            count += 1
    mean = total / count
    return np.sqrt(max(squares / count - mean * mean, 0.0))


@_jit
def _gradient(image, y, x):
    """Magnitude of the Prewitt gradient."""
    across = 0.0
    down = 0.0
    for s in range(-1, 2):
        across += image[y + s, x + 1] - image[y + s, x - 1]
        down += image[y + 1, x + s] - image[y - 1, x + s]
    return np.sqrt(across * across + down * down) / 3.0
