"""PSNR, SSIM and GMSD in one pass, fast enough for a search.

All three are computed in float64 from float32 images; scikit-image is the oracle for PSNR and SSIM,
a plain NumPy twin for GMSD (both in the tests).
"""

from __future__ import annotations

import numba
import numpy as np

NAMES = ("psnr", "ssim", "gmsd")  # the columns
SSIM_WINDOW = 11
SSIM_SIGMA = 1.5
MARGIN = SSIM_WINDOW // 2  # pixels along the edge around which no whole window fits
_GAUSSIAN = np.exp(-0.5 * (np.arange(-MARGIN, MARGIN + 1) / SSIM_SIGMA) ** 2)
W5, W4, W3, W2, W1, W0 = (_GAUSSIAN / _GAUSSIAN.sum())[: MARGIN + 1].tolist()  # W0: the middle
C1, C2 = 0.01**2, 0.03**2
GMSD_CONSTANT = 170.0 / 255.0**2
PSNR_CEILING = 100.0  # dB, for identical images

# sums may be taken in any order, or they would not vectorise
_jit = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"})


def score(rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None) -> np.ndarray:
    """PSNR, SSIM and GMSD of every view, or of the part of it inside a mask.

    PSNR is over all channels, in dB, at most 100. SSIM (Wang et al. 2004) has their window, a
    Gaussian of 1.5 pixels in 11x11, K1 = 0.01, K2 = 0.03 and population covariances, over the
    pixels with a whole window, averaged over channels: as `pytorch-msssim` does it, and
    `torchmetrics`, whose padded border is cut off again, in gsplat's trainer. GMSD (Xue et al.
    2014; lower is better) is the standard deviation of the gradient similarity of the luma halved
    in size, over the pixels with a whole 3x3 neighbourhood.

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
        ValueError: when shapes differ, the images are smaller than 11x11, or a mask has no pixel
            with a whole window around it.
    """
    if rendered.shape != truth.shape or min(rendered.shape[1:3]) < SSIM_WINDOW:
        raise ValueError(
            f"views of equal size, at least {SSIM_WINDOW}x{SSIM_WINDOW}, expected: "
            f"{rendered.shape} against {truth.shape}"
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
    """Mean SSIM of one channel: rows are weighed across, eleven of them at a time down.

    The variances enter as their sum alone, so four fields are weighed: both images, the sum of
    their squares, and their product.
    """
    height, width = first.shape
    fields = np.empty((4, width))
    rows = np.empty((4, SSIM_WINDOW, width - 2 * MARGIN))  # row y is number y modulo the window
    total, windows = 0.0, 0
    for y in range(height):
        for x in range(width):
            a, b = first[y, x], second[y, x]
            fields[0, x], fields[1, x] = a, b
            fields[2, x], fields[3, x] = a * a + b * b, a * b
        for field in range(4):
            _weigh_across(fields[field], rows[field, y % SSIM_WINDOW])
        if y >= SSIM_WINDOW - 1:
            middles = mask[y - MARGIN, MARGIN : width - MARGIN]
            total += _ssim_row(rows, (y + 1) % SSIM_WINDOW, middles)
            windows += middles.sum()
    return total / windows


@_jit
def _weigh_across(line, out):
    for x in range(len(out)):
        out[x] = (
            W0 * line[x + 5]
            + W1 * (line[x + 4] + line[x + 6])
            + W2 * (line[x + 3] + line[x + 7])
            + W3 * (line[x + 2] + line[x + 8])
            + W4 * (line[x + 1] + line[x + 9])
            + W5 * (line[x] + line[x + 10])
        )


@_jit
def _ssim_row(rows, oldest, middles):
    """Sum over one row of windows, of those whose middle counts."""
    down = np.empty((4, len(middles)))
    for field in range(4):
        _weigh_down(rows[field], oldest, down[field])
    total = 0.0
    for x in range(len(middles)):
        a, b = down[0, x], down[1, x]
        squares, product = a * a + b * b, a * b
        value = ((2 * product + C1) * (2 * (down[3, x] - product) + C2)) / (
            (squares + C1) * (down[2, x] - squares + C2)
        )
        total += value if middles[x] else 0.0
    return total


@_jit
def _weigh_down(rows, oldest, out):
    middle = rows[(oldest + 5) % SSIM_WINDOW]
    above, below = rows[(oldest + 4) % SSIM_WINDOW], rows[(oldest + 6) % SSIM_WINDOW]
    above2, below2 = rows[(oldest + 3) % SSIM_WINDOW], rows[(oldest + 7) % SSIM_WINDOW]
    above3, below3 = rows[(oldest + 2) % SSIM_WINDOW], rows[(oldest + 8) % SSIM_WINDOW]
    above4, below4 = rows[(oldest + 1) % SSIM_WINDOW], rows[(oldest + 9) % SSIM_WINDOW]
    above5, below5 = rows[oldest], rows[(oldest + 10) % SSIM_WINDOW]
    for x in range(len(out)):
        out[x] = (
            W0 * middle[x]
            + W1 * (above[x] + below[x])
            + W2 * (above2[x] + below2[x])
            + W3 * (above3[x] + below3[x])
            + W4 * (above4[x] + below4[x])
            + W5 * (above5[x] + below5[x])
        )


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
