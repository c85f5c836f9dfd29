"""The metrics of the paper's tables that need no weights, GMSD in the place of LPIPS."""

from __future__ import annotations

import numpy as np

from fsel.metrics import fused
from fsel.metrics.contract import Metric


def _column(name: str):
    """The score of one metric of the fused pass."""
    column = fused.NAMES.index(name)

    def score(rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None) -> np.ndarray:
        return fused.score(rendered, truth, masks)[:, column]

    return score


PSNR = Metric("psnr", "PSNR", True, _column("psnr"), unit="dB", digits=2)
SSIM = Metric("ssim", "SSIM", True, _column("ssim"))
GMSD = Metric("gmsd", "GMSD", False, _column("gmsd"))
