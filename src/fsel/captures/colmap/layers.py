"""Layers of the networks that find and match features, in NumPy."""

from __future__ import annotations

import numpy as np

EPSILON = 1e-5  # of torch's normalisations


def convolved(image: np.ndarray, weight: np.ndarray, bias: np.ndarray, step: int = 1) -> np.ndarray:
    """(c, h, w) of (b, h, w), or of half the sides; zeros lie beyond the edges."""
    side = weight.shape[-1]
    edge = side // 2
    padded = np.pad(image, ((0, 0), (edge, edge), (edge, edge)))
    seen = np.lib.stride_tricks.sliding_window_view(padded, (side, side), axis=(1, 2))
    out = np.tensordot(weight, seen[:, ::step, ::step], axes=((1, 2, 3), (0, 3, 4)))
    return out + bias[:, None, None]


def deformed(
    image: np.ndarray, offsets: np.ndarray, weight: np.ndarray, bias: np.ndarray
) -> np.ndarray:
    """(c, h, w) of (b, h, w) by a deformable convolution (Dai et al. 2017, equation 2).

    Args:
        image: (b, h, w).
        offsets: (18, h, w) rows and columns, in turn, that each of the nine taps is moved by.
        weight: (c, b, 3, 3).
        bias: (c,).
    """
    count, high, wide = image.shape
    moved = offsets.reshape(9, 2, high, wide)
    down, right = np.divmod(np.arange(9, dtype=np.float32)[:, None, None], 3)
    rows = moved[:, 0] + down - 1 + np.arange(high, dtype=np.float32)[:, None]
    columns = moved[:, 1] + right - 1 + np.arange(wide, dtype=np.float32)
    taps = weight.reshape(-1, count, 9)
    out = np.tensordot(taps, sampled(image, rows, columns), axes=((1, 2), (0, 1)))
    return out + bias[:, None, None]


def sampled(maps: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(c, ...) values of (c, h, w) maps between pixels; zeros lie beyond the edges."""
    _, high, wide = maps.shape
    top, left = np.floor(rows), np.floor(columns)
    out = np.zeros((len(maps), *rows.shape), np.float32)
    for row, column in ((top, left), (top, left + 1), (top + 1, left), (top + 1, left + 1)):
        share = (1 - np.abs(rows - row)) * (1 - np.abs(columns - column))
        share[(row < 0) | (row >= high) | (column < 0) | (column >= wide)] = 0
        y, x = (np.clip(v, 0, s - 1).astype(np.intp) for v, s in ((row, high), (column, wide)))
        out += maps[:, y, x] * share
    return out


def selu(values: np.ndarray) -> np.ndarray:
    """Scaled exponential linear units (Klambauer et al. 2017), in place."""
    below = np.minimum(values, 0)
    np.maximum(values, 0, out=values)
    values += np.float32(1.6732632423543772) * np.expm1(below, out=below)
    values *= np.float32(1.0507009873554805)
    return values


def sigmoid(values: np.ndarray) -> np.ndarray:
    """Logistic function of numbers, without the overflow of an exponential."""
    return (1 + np.tanh(values / 2)) / 2


def softmax(values: np.ndarray, axis: int = -1) -> np.ndarray:
    """Shares of exponentials along an axis."""
    raised = np.exp(values - values.max(axis=axis, keepdims=True))
    raised /= raised.sum(axis=axis, keepdims=True)
    return raised
