"""Images without content: sharpness, descriptors, metrics."""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.captures.images.sharpness import sharpness
from fsel.experiments.studies.hard_cases.case import Case, Finding, finite
from fsel.features.appearance import descriptors
from fsel.metrics import PSNR_CEILING, score_views

SHAPE = (3, 24, 32, 3)
C1 = 0.01**2  # of SSIM, for images in 0..1


def blank(level: int) -> Finding:
    """A uniform image has no sharpness, a descriptor of length one (black: none), and is itself."""
    images = np.full(SHAPE, level, np.uint8)
    sharp, described = sharpness(images), descriptors(images, "lab_hog")
    scores = score_views((images / np.float32(255)).astype(np.float32), images)
    finite(sharp, described, scores)
    length = np.linalg.norm(described.astype(np.float64), axis=1)
    error = max(
        np.abs(sharp).max(),
        np.abs(length - (level > 0)).max(),
        np.abs(scores[:, 1] - 1).max(),
        np.abs(scores[:, 2]).max(),
    )
    told = f"sharpness {sharp[0]:.2g}; descriptor {length[0]:.6f}; PSNR {scores[0, 0]:.1f} dB"
    return Finding(told, float(error) if scores[0, 0] >= PSNR_CEILING else np.inf, 1e-6)


def black_against_white() -> Finding:
    """PSNR 0 dB and SSIM C1 / (1 + C1): means differ by one and nothing varies."""
    scores = score_views(np.zeros(SHAPE, np.float32), np.full(SHAPE, 255, np.uint8))
    finite(scores)
    error = max(np.abs(scores[:, 0]).max(), np.abs(scores[:, 1] - C1 / (1 + C1)).max())
    return Finding(f"PSNR {scores[0, 0]:.3g} dB; SSIM {scores[0, 1]:.6f}", float(error), 1e-9)


ASKED = "sharpness 0; a unit descriptor, none for black; SSIM 1 and GMSD 0 with itself"
CASES = (
    *(
        Case(f"{name} images", ASKED, partial(blank, level))
        for name, level in (("black", 0), ("uniform grey", 119), ("white", 255))
    ),
    Case("black against white", "PSNR 0 dB; SSIM C1 / (1 + C1)", black_against_white),
)
