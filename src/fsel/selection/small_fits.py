"""Small reconstructions that say what selections are worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.metrics import score_views
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.splats import Splats

SIDE = 64  # pixels
SETTINGS: dict[str, Any] = {"steps": 150, "gaussians": 2000, "background": "mean"}
METRICS = ("psnr", "ssim")
BLOCK = 32  # frames that are opened at a time, at the size they have

Scorer = Callable[[np.ndarray, int | None], np.ndarray]
"""(K,) frames -> (W, 2) PSNR in dB and SSIM by `gaussians` of a seed, or, for None, `splats`."""


def small_fits(capture: Capture, validation: np.ndarray, picks: Sequence[np.ndarray]) -> Scorer:
    """Make what fits the selections at a small size and scores them on (W,) validation frames."""
    needed = np.unique(np.concatenate([validation, *picks]))
    small, rows = _small(capture, needed), np.searchsorted(needed, validation)
    truth, views = np.asarray(small.images[rows]), small.view(rows)
    masks = None if small.masks is None else small.masks[rows]

    def score(frames: np.ndarray, seed: int | None) -> np.ndarray:
        by = Splats(small) if seed is None else Gaussians(small, **SETTINGS, seed=seed)
        model = by.fit(np.searchsorted(needed, frames))
        return score_views(model.render(views), truth, masks, METRICS)

    return score


def _small(capture: Capture, frames: np.ndarray) -> Capture:
    """Some frames of a capture at the size of the trials, opened a few at a time."""
    blocks = np.array_split(frames, len(frames) // BLOCK + 1)
    parts = [capture.subset(block).resized(SIDE) for block in blocks]
    masks = None
    if capture.masks is not None:
        masks = np.concatenate([np.asarray(part.masks) for part in parts])
    images = np.concatenate([np.asarray(part.images) for part in parts])
    whole = replace(capture, masks=None).subset(frames, images)
    intrinsics = np.concatenate([part.intrinsics for part in parts])
    return replace(whole, intrinsics=intrinsics, masks=masks)
