"""Image metrics of rendered views against the truth: a registry, and one way to score."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from fsel.core.registry import Registry
from fsel.metrics.contract import Metric

if TYPE_CHECKING:  # the names alone import nothing
    import numpy as np

REGISTERED: Registry[Metric] = Registry(
    "metric",
    {
        "psnr": "fsel.metrics.fused:PSNR",
        "ssim": "fsel.metrics.fused:SSIM",
        "gmsd": "fsel.metrics.fused:GMSD",
        "lpips": "fsel.metrics.lpips:METRIC",
    },
    group="fsel.metrics",
)
"""Every metric by name. The config's `metrics` chooses those of the tables."""

METRICS = ("psnr", "ssim", "gmsd")
"""The metrics unless others are chosen; they cost one pass and need no weights."""

Metrics = Collection[str]
"""Names of metrics; in a mapping name -> settings, those with settings have them."""

__all__ = [
    "METRICS",
    "REGISTERED",
    "Metric",
    "Metrics",
    "checked",
    "directions",
    "headings",
    "score_views",
    "units",
]


def score_views(
    rendered: np.ndarray,
    truth: np.ndarray,
    masks: np.ndarray | None = None,
    metrics: Metrics = METRICS,
) -> np.ndarray:
    """Score every view, or the part of it inside a mask.

    PSNR, SSIM and GMSD are computed in one pass (`fsel.metrics.fused`), others one by one.

    Args:
        rendered: (T, h, w, 3) float32 in [0, 1].
        truth: (T, h, w, 3) uint8.
        masks: (T, h, w) bool, or None for all pixels.
        metrics: M keys of `REGISTERED`, or key -> settings.

    Returns:
        (T, M) float64, columns as `metrics`.

    Raises:
        ValueError: for an unknown metric, when shapes differ, the images are smaller than 11x11, a
            mask has no pixel with a whole window around it, or a rendered value is not finite.
    """
    import numpy as np

    from fsel.metrics import fused

    if not np.isfinite(rendered).all():
        view = int(np.argmin(np.isfinite(rendered).all(axis=(1, 2, 3))))
        raise ValueError(f"view {view} is rendered with values that are not finite")
    columns, settings = {}, _settings(metrics)
    if set(settings) & set(fused.NAMES):
        together = fused.score(rendered, truth, masks)
        columns = dict(zip(fused.NAMES, together.T, strict=True))
    for name in settings.keys() - columns.keys():
        columns[name] = REGISTERED.checked(name).score(rendered, truth, masks, **settings[name])
    return np.stack([columns[name] for name in settings], axis=1)


def checked(metrics: Metrics) -> dict[str, Mapping[str, Any]]:
    """Return name -> settings of the metrics, once each is known to work with them.

    Raises:
        ValueError, FileNotFoundError, ImportError: for an unknown metric, or settings it refuses.
    """
    chosen = _settings(metrics)
    for name, settings in chosen.items():
        check = REGISTERED.checked(name).check
        if check is not None:
            check(**settings)
        elif settings:
            raise ValueError(f"metric {name!r} has no settings, got {sorted(settings)}")
    return chosen


def _settings(metrics: Metrics) -> dict[str, Mapping[str, Any]]:
    return dict(metrics) if isinstance(metrics, Mapping) else {name: {} for name in metrics}


def units(metrics: Metrics = METRICS) -> dict[str, str]:
    """Return metric -> unit, of those that have one."""
    return {name: REGISTERED[name].unit for name in metrics if REGISTERED[name].unit}


def directions(metrics: Metrics = METRICS) -> dict[str, bool]:
    """Return metric -> whether higher is better, in the given order."""
    return {name: REGISTERED[name].higher_is_better for name in metrics}


def headings(metrics: Metrics = METRICS) -> list[str]:
    r"""Return LaTeX headings: a metric's label, its network if any, an arrow to the better."""
    arrows = {True: r"$\uparrow$", False: r"$\downarrow$"}
    labels = []
    for name, settings in _settings(metrics).items():
        network = f" ({settings['net']})" if "net" in settings else ""
        labels.append(REGISTERED[name].label + network + arrows[REGISTERED[name].higher_is_better])
    return labels
