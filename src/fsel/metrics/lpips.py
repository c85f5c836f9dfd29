"""LPIPS (Zhang et al. 2018), once the weights of its backbone are on disk.

The package `lpips` has the linear heads alone (version 0.1); it imports torchvision for the
backbones. Here their layers are written out in `fsel.metrics.backbones`, so that neither package is
imported: the heads are read from a file of the package `lpips`, the backbone from a file of weights
that torchvision publishes.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.metrics.contract import Metric

if TYPE_CHECKING:
    from fsel.metrics.backbones import Lpips

PAGES = {
    "alex": "https://download.pytorch.org/models/alexnet-owt-7be5be79.pth",
    "vgg": "https://download.pytorch.org/models/vgg16-397923af.pth",
    "squeeze": "https://download.pytorch.org/models/squeezenet1_1-b8a52dc0.pth",
}
"""Backbone -> where its weights are, trained on ImageNet by torchvision."""


def located(net: str = "vgg", weights: str | None = None) -> tuple[Path, Path]:
    """Files of the backbone's weights and of the linear heads; nothing is read.

    Args:
        net: a key of `PAGES`.
        weights: state dict of torchvision's model, .pth or .safetensors.

    Raises:
        ValueError: for an unknown backbone.
        FileNotFoundError: when the weights are not where they should be.
        ImportError: without the package `lpips` or torch.
    """
    if net not in PAGES:
        raise ValueError(f"lpips.net is {net!r}; allowed: {', '.join(PAGES)}")
    if weights is None or not Path(weights).is_file():
        raise FileNotFoundError(
            f"lpips.weights is {str(weights)!r}, not a file; LPIPS with net {net} needs the "
            f"weights {PAGES[net]} on disk. Hint: fetch them and give the path, or put gmsd in the "
            "place of lpips in `metrics`"
        )
    for package, extra in (("lpips", "weights"), ("torch", "workflow")):
        if find_spec(package) is None:
            raise ImportError(
                f"metric 'lpips' needs the package {package}: pip install 'fsel[{extra}]', or put "
                "gmsd in its place in `metrics`"
            )
    spec = find_spec("lpips")
    folders = list(spec.submodule_search_locations or []) if spec else []
    return Path(weights), Path(folders[0], "weights", "v0.1", f"{net}.pth")


def check(net: str = "vgg", weights: str | None = None) -> None:
    """Read the network, before any work starts; arguments and errors are those of `located`.

    Raises:
        ValueError: for files that do not hold the backbone's or the heads' layers.
    """
    _network(net, *located(net, weights))


def score(
    rendered: np.ndarray,
    truth: np.ndarray,
    masks: np.ndarray | None,
    net: str = "vgg",
    weights: str | None = None,
) -> np.ndarray:
    """LPIPS of every view, in float32, on a GPU where there is one.

    With masks nothing outside them counts: there the rendering is taken to be the truth, and a
    layer's positions weigh as much as the mask fills them.

    Args:
        rendered: (T, h, w, 3) float32 in [0, 1].
        truth: (T, h, w, 3) uint8.
        masks: (T, h, w) bool, or None for all pixels.
        net, weights: see `located`.

    Returns:
        (T,) float64; 0 for identical images.

    Raises:
        ValueError: when shapes differ, or the images are too small for the backbone.
    """
    if rendered.shape != truth.shape:
        raise ValueError(f"views of equal size expected: {rendered.shape} against {truth.shape}")
    network = _network(net, *located(net, weights))
    reference = truth.astype(np.float32) / 255
    if masks is not None:
        rendered = np.where(masks[..., None], rendered, reference)
    return network.distances(rendered, reference, masks)


@cache
def _network(net: str, weights: Path, heads: Path) -> Lpips:
    from fsel.metrics.backbones import Lpips

    return Lpips.read(net, weights, heads)


METRIC = Metric("lpips", "LPIPS", False, score, check=check)
