"""LPIPS (Zhang et al. 2018, version 0.1), once its weights are on disk."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.metrics import published
from fsel.metrics.fused import Metric

if TYPE_CHECKING:
    from fsel.metrics.backbones import Lpips

PAGES = {
    "alex": "https://download.pytorch.org/models/alexnet-owt-7be5be79.pth",
    "vgg": "https://download.pytorch.org/models/vgg16-397923af.pth",
}
"""Backbone -> where its weights are, trained on ImageNet by torchvision."""
NET = "alex"
"""The backbone unless another is named, as of the authors' package."""
HEAD = "lin0.model.1.weight"  # the first head, as the package `lpips` names it


def located(net: str = NET, weights: str | None = None) -> tuple[Path, Path]:
    """Find the files of the backbone's weights and of the linear heads; no layer is read.

    Args:
        net: a key of `PAGES`.
        weights: state dict of torchvision's model, .pth or .safetensors, whose heads are those of
            the package `lpips`; or a file that `published.fetch` wrote, which has both. None for
            such a file in `downloads` or the user's cache.

    Raises:
        ValueError, FileNotFoundError: for an unknown backbone, or weights that are not there.
        ImportError: without torch, or without the package `lpips` where it has the heads.
    """
    if net not in PAGES:
        raise ValueError(f"lpips.net is {net!r}; allowed: {', '.join(PAGES)}")
    path = published.found(net) if weights is None else Path(weights)
    if path is None or not path.is_file():
        raise FileNotFoundError(
            f"lpips.weights is {weights and str(weights)!r}, not a file; LPIPS with net {net} "
            f"needs the weights {PAGES[net]} on disk. Hint: `fsel compare --metrics psnr,lpips` "
            "fetches them, of alex; put gmsd in the place of lpips in `metrics`"
        )
    whole = _holds_heads(path)
    for package, extra in (("lpips", "weights"), ("torch", "workflow")):
        if find_spec(package) is None and not (whole and package == "lpips"):
            raise ImportError(
                f"metric 'lpips' needs the package {package}: pip install 'fsel[{extra}]', or put "
                "gmsd in its place in `metrics`"
            )
    spec = None if whole else find_spec("lpips")
    folders = list(spec.submodule_search_locations or []) if spec else []
    return path, Path(folders[0], "weights", "v0.1", f"{net}.pth") if folders else path


def _holds_heads(path: Path) -> bool:
    if path.suffix != ".safetensors":
        return False
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(path, "np") as opened:
            return HEAD in opened.keys()  # noqa: SIM118 -- no dictionary
    except SafetensorError:
        return True  # reading it says what is wrong


def check(net: str = NET, weights: str | None = None) -> None:
    """Read the network before any work starts; arguments and errors are those of `located`."""
    _network(net, *located(net, weights))


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
    network = _network(net, *located(net, weights))
    if masks is not None:
        rendered = np.where(masks[..., None], rendered, truth.astype(np.float32) / 255)
    return network.distances(rendered, truth, masks)


@cache
def _network(net: str, weights: Path, heads: Path) -> Lpips:
    from fsel.metrics.backbones import Lpips

    return Lpips.read(net, weights, heads)


METRIC = Metric("lpips", "LPIPS", False, score, check=check)
