"""Appearance descriptors: one unit vector a frame."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

GRID = 4
BINS = 8
DINOV2 = "vit_small_patch14_dinov2.lvd142m"
DINOV2_SIDE = 224
KERNEL_JITTER = 1e-6  # added to the diagonal of a kernel of descriptors, which may be singular
IMAGENET = np.array([[0.485, 0.456, 0.406], [0.229, 0.224, 0.225]], np.float32)


def descriptors(images: np.ndarray, kind: str, weights: str | None = None) -> np.ndarray:
    """Describe every image.

    Args:
        images: (N, h, w, 3) uint8 RGB.
        kind: `lab_hog`, which needs no weights, or `dinov2` (ViT-S/14 CLS token through timm).
        weights: path of a DINOv2 checkpoint; only for `dinov2`.

    Returns:
        (N, D) float32, rows of unit length; cosine similarity is their dot product.

    Raises:
        ValueError: for an unknown kind, or weights given to a kind that has none.
        FileNotFoundError: when the weights are not where they should be.
    """
    if kind not in KINDS:
        raise ValueError(f"appearance.kind is {kind!r}; allowed: {', '.join(sorted(KINDS))}")
    raw = KINDS[kind](images, weights)
    length = np.linalg.norm(raw, axis=1, keepdims=True)
    return (raw / np.where(length > 0, length, 1)).astype(np.float32)


def _lab_hog(images: np.ndarray, weights: str | None) -> np.ndarray:
    """CIE Lab means and gradient-orientation histograms on a 4x4 grid (Dalal and Triggs 2005)."""
    if weights is not None:
        raise ValueError("appearance.weights is set, but lab_hog has none; did you mean dinov2?")
    return np.stack([_describe(np.ascontiguousarray(image)) for image in images])


def _describe(image: np.ndarray) -> np.ndarray:
    lab = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2LAB) / 100
    layout = cv2.resize(lab, (GRID, GRID), interpolation=cv2.INTER_AREA)
    light = lab[..., 0]
    across = cv2.Sobel(light, cv2.CV_32F, 1, 0)
    down = cv2.Sobel(light, cv2.CV_32F, 0, 1)
    strength, angle = cv2.cartToPolar(across, down)
    # unsigned orientation: opposite gradients are the same edge
    bins = ((angle % np.pi) / np.pi * BINS).astype(int) % BINS
    maps = strength[..., None] * (bins[..., None] == np.arange(BINS))
    # one channel at a time: beyond four, INTER_AREA wants a size that the grid divides
    cells = np.stack(
        [
            cv2.resize(channel, (GRID, GRID), interpolation=cv2.INTER_AREA)
            for channel in np.moveaxis(maps.astype(np.float32), 2, 0)
        ],
        axis=-1,
    )
    norm = np.linalg.norm(cells)
    edges = cells.ravel() / norm if norm > 0 else cells.ravel()
    colour = layout.ravel() / GRID
    return np.concatenate([colour, edges])


def _dinov2(images: np.ndarray, weights: str | None) -> np.ndarray:
    if weights is None or not Path(weights).is_file():
        raise FileNotFoundError(
            f"appearance.weights is {weights!r}, not a file; dinov2 needs the checkpoint of "
            f"{DINOV2} on disk, or set appearance.kind to lab_hog"
        )
    try:
        import timm
    except ImportError as error:
        raise ImportError(
            "appearance.kind dinov2 needs the package timm: pip install 'fsel[weights]', or set "
            "appearance.kind to lab_hog"
        ) from error
    import torch

    # loaded as pretrained weights, not as a checkpoint: only so are the position embeddings, made
    # for 518 pixels, resampled to this side
    model = timm.create_model(
        DINOV2,
        pretrained=True,
        pretrained_cfg_overlay={"file": str(weights)},
        img_size=DINOV2_SIDE,
        num_classes=0,
    ).eval()
    rows = []
    with torch.inference_mode():
        for image in images:
            side = (DINOV2_SIDE, DINOV2_SIDE)
            small = cv2.resize(np.ascontiguousarray(image), side, interpolation=cv2.INTER_AREA)
            scaled = (small.astype(np.float32) / 255 - IMAGENET[0]) / IMAGENET[1]
            rows.append(model(torch.from_numpy(scaled).permute(2, 0, 1)[None])[0].numpy())
    return np.stack(rows)


KINDS = {"lab_hog": _lab_hog, "dinov2": _dinov2}
