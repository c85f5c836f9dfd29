"""Image metrics of rendered views against the truth: a registry, and one way to score."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsel.metrics import fused
from fsel.metrics.contract import Metric
from fsel.metrics.fused import PSNR_CEILING, inside
from fsel.registry import Registry

REGISTERED: Registry[Metric] = Registry(
    "metric",
    {
        "psnr": "fsel.metrics.builtin:PSNR",
        "ssim": "fsel.metrics.builtin:SSIM",
        "gmsd": "fsel.metrics.builtin:GMSD",
    },
)
"""Every metric by name. The config's `metrics` chooses those of the budget sweep."""

METRICS = fused.NAMES
"""Those that searches and the other tables measure; they cost one pass."""

__all__ = [
    "HIGHER_IS_BETTER",
    "METRICS",
    "METRIC_UNITS",
    "PSNR_CEILING",
    "REGISTERED",
    "Metric",
    "directions",
    "headings",
    "inside",
    "score_views",
    "units",
]


def score_views(
    rendered: np.ndarray,
    truth: np.ndarray,
    masks: np.ndarray | None = None,
    metrics: Sequence[str] = METRICS,
) -> np.ndarray:
    """Metrics of every view, or of the part of it inside a mask.

    PSNR, SSIM and GMSD are computed in one pass (`fsel.metrics.fused`), others one by one.

    Args:
        rendered: (T, h, w, 3) float32 in [0, 1].
        truth: (T, h, w, 3) uint8.
        masks: (T, h, w) bool, or None for all pixels.
        metrics: M keys of `REGISTERED`.

    Returns:
        (T, M) float64, columns as `metrics`.

    Raises:
        ValueError: for an unknown metric, when shapes differ, the images are smaller than 8x8, or
            a mask has no pixel with a whole window around it.
    """
    if tuple(metrics) == fused.NAMES:
        return fused.score(rendered, truth, masks)
    columns = {}
    if set(metrics) & set(fused.NAMES):
        together = fused.score(rendered, truth, masks)
        columns = dict(zip(fused.NAMES, together.T, strict=True))
    for name in set(metrics) - set(columns):
        columns[name] = REGISTERED.checked(name).score(rendered, truth, masks)
    return np.stack([columns[name] for name in metrics], axis=1)


def units(metrics: Sequence[str] = METRICS) -> dict[str, str]:
    """Metric -> unit, of those that have one."""
    return {name: REGISTERED[name].unit for name in metrics if REGISTERED[name].unit}


def directions(metrics: Sequence[str] = METRICS) -> dict[str, bool]:
    """Metric -> whether higher is better, in the given order."""
    return {name: REGISTERED[name].higher_is_better for name in metrics}


def headings(metrics: Sequence[str] = METRICS) -> list[str]:
    r"""LaTeX headings: each metric's label and an arrow towards the better."""
    arrows = {True: r"$\uparrow$", False: r"$\downarrow$"}
    found = [REGISTERED[name] for name in metrics]
    return [metric.label + arrows[metric.higher_is_better] for metric in found]


HIGHER_IS_BETTER = directions(METRICS)
METRIC_UNITS = units(METRICS)
