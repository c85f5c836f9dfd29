"""Appearance descriptors: one unit vector a frame."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np

GRID = 4
BINS = 8
LAB_HOG = "lab_hog"
KINDS = (LAB_HOG, "dinov2")
CONFIGURED = ("appearance.kind", "appearance.weights")  # as a configuration names them
DINOV2 = "vit_small_patch14_dinov2.lvd142m"
DINOV2_SIDE = 224
DINOV2_PAGE = "https://huggingface.co/timm/vit_small_patch14_dinov2.lvd142m"
BATCH = 32  # images through the network at once
KERNEL_JITTER = 1e-6  # added to the diagonal of a kernel of descriptors, which may be singular
IMAGENET = np.array([[0.485, 0.456, 0.406], [0.229, 0.224, 0.225]], np.float32)


def descriptors(images: np.ndarray, kind: str, weights: str | None = None) -> np.ndarray:
    """Describe every image.

    Args:
        images: (N, h, w, 3) uint8 RGB.
        kind: `lab_hog`, CIE Lab means and gradient-orientation histograms on a 4x4 grid (Dalal and
            Triggs 2005), or `dinov2` (Oquab et al. 2024): the class token of ViT-S/14 through timm,
            of the whole frame at 224x224, on a GPU where there is one. The paper states no model.
        weights: path of a DINOv2 checkpoint; only for `dinov2`.

    Returns:
        (N, D) float32, rows of unit length; cosine similarity is their dot product.

    Raises: as `check`.
    """
    check(kind, weights)
    raw = _dinov2(images, weights) if kind == "dinov2" else np.stack([*map(_lab_hog, images)])
    length = np.linalg.norm(raw, axis=1, keepdims=True)
    return (raw / np.where(length > 0, length, 1)).astype(np.float32)


def check(kind: str, weights: str | None = None, named: tuple[str, str] = CONFIGURED) -> None:
    """Refuse what `descriptors` could not make, before images are read, by the names `named` that a
    person calls kind and weights.

    Raises:
        ValueError: for an unknown kind, or weights given to a kind that has none.
        FileNotFoundError, ImportError: without the weights or the packages of `dinov2`.
    """
    kind_named, weights_named = named
    if kind not in KINDS:
        raise ValueError(f"{kind_named} is {kind!r}; allowed: {', '.join(sorted(KINDS))}")
    if kind != "dinov2":
        if weights is not None:
            raise ValueError(f"{weights_named} is set, but {kind} has none; did you mean dinov2?")
        return
    if weights is None or not Path(weights).is_file():
        raise FileNotFoundError(
            f"{weights_named} is {weights!r}, not a file; dinov2 needs the checkpoint of "
            f"{DINOV2} on disk, from {DINOV2_PAGE}. Hint: give its path, or set {kind_named} to "
            "lab_hog"
        )
    for package, extra in (("timm", "weights"), ("torch", "workflow")):
        found = sys.modules[package] if package in sys.modules else find_spec(package)
        if found is None:
            raise ImportError(
                f"{kind_named} dinov2 needs the package {package}: pip install 'fsel[{extra}]', "
                f"or set {kind_named} to lab_hog"
            )


def _lab_hog(image: np.ndarray) -> np.ndarray:
    pixels = np.ascontiguousarray(image).astype(np.float32)
    lab = cv2.cvtColor(pixels / 255, cv2.COLOR_RGB2LAB) / 100
    layout = cv2.resize(lab, (GRID, GRID), interpolation=cv2.INTER_AREA)
    light = lab[..., 0]
    gradient = cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1)
    strength, angle = cv2.cartToPolar(*gradient)
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
    return np.concatenate([layout.ravel() / GRID, edges])


def _dinov2(images: np.ndarray, weights: str | None) -> np.ndarray:
    import timm
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
    device = "cuda" if torch.cuda.is_available() else "cpu"
    model, rows, side = model.to(device), [], (DINOV2_SIDE, DINOV2_SIDE)
    with torch.inference_mode():
        for start in range(0, len(images), BATCH):
            part = [np.ascontiguousarray(image) for image in images[start : start + BATCH]]
            small = np.stack([cv2.resize(i, side, interpolation=cv2.INTER_AREA) for i in part])
            scaled = (small.astype(np.float32) / 255 - IMAGENET[0]) / IMAGENET[1]
            batch = torch.from_numpy(scaled).permute(0, 3, 1, 2).to(device)
            rows.append(model(batch).cpu().numpy())
    return np.concatenate(rows)
