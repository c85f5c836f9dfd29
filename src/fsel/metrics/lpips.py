"""LPIPS (Zhang et al. 2018, version 0.1), once its weights are on disk."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.metrics import published
from fsel.metrics.contract import Metric

if TYPE_CHECKING:
    from fsel.metrics.backbones import Lpips

NET = "alex"
"""The backbone unless another is named, as of the authors' package."""


def located(net: str = NET, weights: str | None = None) -> Path:
    """Find the file of the weights; no layer is read.

    Args:
        net: a key of `published.PICKLES`.
        weights: a file that `published.fetch` wrote; None for the one in `downloads` or the user's
            cache.

    Raises:
        ValueError, FileNotFoundError, ImportError: for an unknown backbone, weights that are not
            there, or torch that is not installed.
    """
    if net not in published.PICKLES:
        raise ValueError(f"lpips.net is {net!r}; allowed: {', '.join(published.PICKLES)}")
    path = published.found(net) if weights is None else Path(weights)
    if path is None or not path.is_file():
        raise FileNotFoundError(
            f"lpips.weights is {weights and str(weights)!r}, not a file. Hint: leave it out: "
            "a run of the workflow or `fsel compare --metrics psnr,lpips` fetches the weights; or "
            "put gmsd in the place of lpips in `metrics`"
        )
    if find_spec("torch") is None:
        raise ImportError(
            "metric 'lpips' needs the package torch: pip install 'fsel[workflow]', or put gmsd in "
            "its place in `metrics`"
        )
    return path


def check(net: str = NET, weights: str | None = None) -> None:
    """Read the network before any work starts; arguments and errors are those of `located`."""
    _network(net, located(net, weights))


def score(
    rendered: np.ndarray,
    truth: np.ndarray,
    masks: np.ndarray | None,
    net: str = NET,
    weights: str | None = None,
) -> np.ndarray:
    """Return (T,) float64 LPIPS of views, 0 for identical ones; see `Metric.score` and `located`.

    It is float32, on a GPU where there is one. With masks nothing outside them counts: there the
    rendering is taken to be the truth, and a layer's positions weigh as the mask fills them.

    Raises:
        ValueError: when shapes differ, or the images are too small for the backbone.
    """
    if rendered.shape != truth.shape:
        raise ValueError(f"views of equal size expected: {rendered.shape} against {truth.shape}")
    network = _network(net, located(net, weights))
    if masks is not None:
        rendered = np.where(masks[..., None], rendered, truth.astype(np.float32) / 255)
    return network.distances(rendered, truth, masks)


@cache
def _network(net: str, weights: Path) -> Lpips:
    from fsel.metrics.backbones import Lpips

    return Lpips.read(net, weights)


METRIC = Metric("lpips", "LPIPS", False, score, check=check)
