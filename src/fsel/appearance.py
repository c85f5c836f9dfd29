"""Appearance descriptors: what stands behind the similarities rho of the paper's features.

The paper uses DINOv2; it needs weights that a fresh machine does not have. Without them a named
descriptor of colour layout and gradient orientations stands in, and every run says which it used.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

WEIGHTLESS = "color_gradient"
DINOV2 = "dinov2"
KINDS = (WEIGHTLESS, DINOV2)

CELLS = 4  # the image is a grid of 4 x 4 cells
BINS = 8  # gradient orientations a cell, without sign
LONG_SIDE = 128  # pixels; a descriptor does not depend on more detail

DINOV2_MODEL = "vit_small_patch14_dinov2.lvd142m"
DINOV2_SIDE = 224
DINOV2_BATCH = 32
_MEAN = np.array([0.485, 0.456, 0.406], np.float32)
_STD = np.array([0.229, 0.224, 0.225], np.float32)


def descriptors(
    images: np.ndarray, kind: str = WEIGHTLESS, weights: str | Path | None = None
) -> np.ndarray:
    """Appearance descriptors of images, whose dot products are the similarities rho.

    Args:
        images: (N, h, w, 3) uint8, RGB.
        kind: `color_gradient` (176 numbers: mean CIELAB colour of 4 x 4 cells about the image's
            mean lightness, and Hellinger histograms of gradient orientation in the same cells) or
            `dinov2` (class token of DINOv2 ViT-S/14 at 224 x 224, 384 numbers).
        weights: checkpoint file of DINOv2 as `timm` reads it; `color_gradient` takes none.

    Returns:
        (N, D) float32 rows of unit length.

    Raises:
        ValueError: for an unknown kind, or weights given to a kind that takes none.
        FileNotFoundError: when the checkpoint is missing.
        ImportError: when `timm` is missing.
    """
    if kind not in KINDS:
        raise ValueError(f"descriptor must be one of {KINDS}, got {kind!r}")
    if kind == DINOV2:
        return _unit(_dinov2(images, weights))
    if weights is not None:
        raise ValueError(f"descriptor {kind!r} takes no weights, got {str(weights)!r}")
    return _unit(np.stack([_color_gradient(np.asarray(image)) for image in images]))


def _unit(rows: np.ndarray) -> np.ndarray:
    """Rows of unit length; a row of zeros (a flat grey image) becomes the uniform direction."""
    rows = rows.astype(np.float64)
    rows[~rows.any(axis=1)] = 1
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


def _color_gradient(image: np.ndarray) -> np.ndarray:
    """(176,) colour layout and orientation histograms of equal weight."""
    height, width = image.shape[:2]
    scale = LONG_SIDE / max(height, width)
    if scale < 1:
        size = (max(CELLS, round(width * scale)), max(CELLS, round(height * scale)))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
    layout = cv2.resize(lab, (CELLS, CELLS), interpolation=cv2.INTER_AREA)
    layout[..., 0] -= lab[..., 0].mean()  # exposure drifts along a capture
    return np.concatenate([_normalised(layout.ravel()), _normalised(_orientations(lab[..., 0]))])


def _orientations(lightness: np.ndarray) -> np.ndarray:
    """(128,) square roots of gradient magnitude by cell and orientation, bins shared linearly."""
    dx = cv2.Sobel(lightness, cv2.CV_32F, 1, 0).astype(np.float64)
    dy = cv2.Sobel(lightness, cv2.CV_32F, 0, 1).astype(np.float64)
    position = np.mod(np.arctan2(dy, dx), np.pi) * (BINS / np.pi)
    lower = np.floor(position).astype(np.int64)
    share = position - lower
    height, width = lightness.shape
    row = np.arange(height) * CELLS // height
    column = np.arange(width) * CELLS // width
    cell = (row[:, None] * CELLS + column) * BINS
    magnitude = np.hypot(dx, dy)
    histogram = np.zeros(CELLS * CELLS * BINS)
    for offset, weight in ((0, 1 - share), (1, share)):
        index = cell + (lower + offset) % BINS
        histogram += np.bincount(index.ravel(), (magnitude * weight).ravel(), len(histogram))
    return np.sqrt(histogram)


def _normalised(vector: np.ndarray) -> np.ndarray:
    return vector / (np.linalg.norm(vector) or 1.0)


def _dinov2(images: np.ndarray, weights: str | Path | None) -> np.ndarray:
    """(N, 384) class tokens."""
    if weights is None or not Path(weights).is_file():
        raise FileNotFoundError(
            f"descriptor 'dinov2' needs a checkpoint file of {DINOV2_MODEL}, got weights="
            f"{None if weights is None else str(weights)!r}; give its path, or use "
            f"{WEIGHTLESS!r}, which needs none"
        )
    try:
        import timm
    except ImportError as error:
        raise ImportError(
            "descriptor 'dinov2' needs the package timm: pip install 'fsel[weights]', or use "
            f"{WEIGHTLESS!r}, which needs neither package nor weights"
        ) from error
    import torch

    model = timm.create_model(
        DINOV2_MODEL,
        pretrained=True,
        pretrained_cfg_overlay={"file": str(weights)},
        img_size=DINOV2_SIDE,
        num_classes=0,
    ).eval()
    tokens = []
    with torch.inference_mode():
        for start in range(0, len(images), DINOV2_BATCH):
            batch = np.stack([_network_input(i) for i in images[start : start + DINOV2_BATCH]])
            tokens.append(model(torch.from_numpy(batch)).numpy())
    return np.concatenate(tokens)


def _network_input(image: np.ndarray) -> np.ndarray:
    """(3, 224, 224) float32 with ImageNet's mean and deviation; the whole frame, squeezed."""
    side = DINOV2_SIDE
    shrinking = max(image.shape[:2]) > side
    interpolation = cv2.INTER_AREA if shrinking else cv2.INTER_CUBIC
    resized = cv2.resize(np.asarray(image), (side, side), interpolation=interpolation)
    return ((resized.astype(np.float32) / 255 - _MEAN) / _STD).transpose(2, 0, 1)
