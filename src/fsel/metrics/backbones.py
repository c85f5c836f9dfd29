"""LPIPS on the convolutions of AlexNet and VGG16, numbered as in torchvision; imports torch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor
from torch.nn.functional import adaptive_avg_pool2d, conv2d, max_pool2d

# of inputs in [-1, 1]: ImageNet's mean and deviation, as the package `lpips` rounds them
SHIFT, SCALE = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)
EPSILON = 1e-10  # added to a feature's length
PIXELS = {"cpu": 1 << 18, "cuda": 1 << 21}  # of a batch of pairs
POOLING = 2  # step of every pooling


class BackboneLayer(NamedTuple):
    """A convolution with the ReLU after it."""

    number: int  # in torchvision's model
    channels: tuple[int, int]  # that it takes and that it gives
    window: int = 3
    stride: int = 1
    padding: int = 1
    pooled: int = 0  # window of the max pooling before it; 0 for none
    compared: bool = True


def _vgg() -> list[BackboneLayer]:
    """VGG16 (Simonyan and Zisserman 2015), to its last convolution."""
    layers: list[BackboneLayer] = []
    channels, number = 3, 0
    for width, count in ((64, 2), (128, 2), (256, 3), (512, 3), (512, 3)):
        for i in range(count):
            pooled = 2 if layers and i == 0 else 0
            last = i == count - 1
            layers.append(BackboneLayer(number, (channels, width), pooled=pooled, compared=last))
            channels, number = width, number + (3 if last else 2)
    return layers


BACKBONES = {
    # Krizhevsky 2014, to its fifth convolution
    "alex": [
        BackboneLayer(0, (3, 64), 11, 4, 2),
        BackboneLayer(3, (64, 192), 5, 1, 2, pooled=3),
        BackboneLayer(6, (192, 384), pooled=3),
        BackboneLayer(8, (384, 256)),
        BackboneLayer(10, (256, 256)),
    ],
    "vgg": _vgg(),
}
LEAST = {"alex": 31, "vgg": 16}
"""Least pixels of an image's shorter side."""


class Lpips:
    """Distance of two images in the features of a backbone (Zhang et al. 2018, version 0.1).

    Args:
        net: a key of `BACKBONES`.
        state: the tensors that `shapes_of` lists.
        device: of torch.
    """

    def __init__(self, net: str, state: Mapping[str, Tensor], device: str = "cpu") -> None:
        self.net, self.device = net, device
        # clones are aligned
        own = {name: state[name].clone().to(device) for name in shapes_of(net)}
        self.layers = [
            (layer, *(own[f"features.{layer.number}.{part}"] for part in ("weight", "bias")))
            for layer in BACKBONES[net]
        ]
        self.heads = [tensor for name, tensor in own.items() if name.startswith("lin")]
        self.shift, self.scale = (
            torch.tensor(values, device=device)[None, :, None, None] for values in (SHIFT, SCALE)
        )
        self._last: tuple[object, list[Tensor]] | None = None

    @classmethod
    def read(cls, net: str, path: Path) -> Lpips:
        """Read a file of `published.fetch`, ValueError for one that does not hold the layers; the
        network is on a GPU where there is one."""
        try:
            state = load_file(path)
        except SafetensorError as error:
            raise ValueError(f"{path}: not a readable file of weights ({error})") from error
        for name, shape in shapes_of(net).items():
            if name not in state or tuple(state[name].shape) != shape:
                there = tuple(state[name].shape) if name in state else "missing"
                wanted = f"{name} is {there}, not {shape}"
                raise ValueError(f"{path}: no weights of LPIPS with net {net}: {wanted}")
        return cls(net, state, "cuda" if torch.cuda.is_available() else "cpu")

    def features_of(self, images: Tensor) -> list[Tensor]:
        """Return (B, C, h', w') unit feature vectors of each compared layer, of (B, 3, h, w) images
        in [-1, 1]."""
        signal, found = (images - self.shift) / self.scale, []
        for layer, weight, bias in self.layers:
            if layer.pooled:
                signal = max_pool2d(signal, layer.pooled, POOLING)
            signal = conv2d(signal, weight, bias, layer.stride, layer.padding).relu()
            if layer.compared:
                # not `sqrt`, which is MKL's and ends in other digits on other processors
                length = torch.linalg.vector_norm(signal, dim=1, keepdim=True)
                found.append(signal / (length + EPSILON))
        return found

    def apart(
        self, first: Sequence[Tensor], second: Sequence[Tensor], weights: Tensor | None = None
    ) -> Tensor:
        """Return (B,) distances of a batch, from what `features_of` gives for each side; `weights`
        are (B, 1, h, w) of the pixels, None for equal ones."""
        means = []
        for head, a, b in zip(self.heads, first, second, strict=True):
            distance = conv2d((a - b).square(), head)
            if weights is None:
                means.append(distance.mean((1, 2, 3)))
            else:
                share = adaptive_avg_pool2d(weights, distance.shape[2:])
                means.append((distance * share).sum((1, 2, 3)) / share.sum((1, 2, 3)))
        return torch.stack(means).sum(0)

    @torch.inference_mode()
    def distances(
        self, images: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None
    ) -> np.ndarray:
        """Return (T,) float64 distances of images from the truth, in batches; features of a truth
        of one batch are kept, for a problem's many renderings."""
        height, width = images.shape[1:3]
        if min(height, width) < LEAST[self.net]:
            raise ValueError(
                f"LPIPS with net {self.net} needs images of {LEAST[self.net]} pixels or more, got "
                f"{width}x{height}"
            )
        batch = max(1, PIXELS[self.device] // (height * width))
        scores = []
        for start in range(0, len(images), batch):
            part = slice(start, start + batch)
            known = self._known(truth) if batch >= len(images) else self._seen(truth[part])
            counted = None
            if masks is not None:
                counted = torch.from_numpy(masks[part].astype(np.float32))[:, None]
                counted = counted.to(self.device)
            distances = self.apart(self._seen(images[part]), known, counted)
            scores.append(distances.cpu().numpy().astype(np.float64))
        return np.concatenate(scores)

    def _known(self, truth: np.ndarray) -> list[Tensor]:
        """Return the features of a truth; those of the last one are kept."""
        key = truth.shape, blake2b(truth.tobytes()).digest()
        if self._last is None or self._last[0] != key:
            self._last = key, self._seen(truth)
        return self._last[1]

    def _seen(self, images: np.ndarray) -> list[Tensor]:
        """Return the features of (B, h, w, 3) images, float32 in [0, 1] or uint8."""
        if images.dtype == np.uint8:
            images = images.astype(np.float32) / 255
        own = torch.from_numpy(np.ascontiguousarray(images, np.float32)).to(self.device)
        return self.features_of(own.permute(0, 3, 1, 2) * 2 - 1)


def shapes_of(net: str) -> dict[str, tuple[int, ...]]:
    """Return name -> shape of a backbone's tensors and its heads', as torchvision names them."""
    shapes: dict[str, tuple[int, ...]] = {}
    for layer in BACKBONES[net]:
        taken, given = layer.channels
        shapes[f"features.{layer.number}.weight"] = (given, taken, layer.window, layer.window)
        shapes[f"features.{layer.number}.bias"] = (given,)
    compared = [layer.channels[1] for layer in BACKBONES[net] if layer.compared]
    return shapes | {f"lin{i}.model.1.weight": (1, n, 1, 1) for i, n in enumerate(compared)}
