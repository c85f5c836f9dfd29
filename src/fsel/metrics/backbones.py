"""Feature layers of AlexNet, VGG16 and SqueezeNet 1.1, and LPIPS on them; imports torch.

Layers are numbered as in torchvision's models, whose files of weights they read.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from pickle import UnpicklingError

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import adaptive_avg_pool2d

# of inputs in [-1, 1]: ImageNet's mean and deviation, as the package `lpips` rounds them
SHIFT, SCALE = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)
EPSILON = 1e-10  # added to a feature's length
PIXELS = {"cpu": 1 << 18, "cuda": 1 << 21}  # of a batch of pairs


class Fire(nn.Module):
    """Squeeze to few channels, then expand by 1x1 and 3x3 windows (Iandola et al. 2016)."""

    def __init__(self, channels: int, squeezed: int, expanded: int) -> None:
        super().__init__()
        self.squeeze = nn.Conv2d(channels, squeezed, 1)
        self.expand1x1 = nn.Conv2d(squeezed, expanded, 1)
        self.expand3x3 = nn.Conv2d(squeezed, expanded, 3, padding=1)

    def forward(self, image: Tensor) -> Tensor:
        few = self.squeeze(image).relu()
        return torch.cat([self.expand1x1(few).relu(), self.expand3x3(few).relu()], 1)


def _alex() -> list[nn.Module]:
    """AlexNet (Krizhevsky 2014), to its fifth convolution."""
    convolutions = [
        nn.Conv2d(3, 64, 11, stride=4, padding=2),
        nn.Conv2d(64, 192, 5, padding=2),
        nn.Conv2d(192, 384, 3, padding=1),
        nn.Conv2d(384, 256, 3, padding=1),
        nn.Conv2d(256, 256, 3, padding=1),
    ]
    layers: list[nn.Module] = []
    for i, convolution in enumerate(convolutions):
        layers += [nn.MaxPool2d(3, 2)] if i in (1, 2) else []
        layers += [convolution, nn.ReLU()]
    return layers


def _vgg() -> list[nn.Module]:
    """VGG16 (Simonyan and Zisserman 2015), to its last convolution."""
    layers: list[nn.Module] = []
    channels = 3
    for width, count in ((64, 2), (128, 2), (256, 3), (512, 3), (512, 3)):
        layers += [nn.MaxPool2d(2, 2)] if layers else []
        for _ in range(count):
            layers += [nn.Conv2d(channels, width, 3, padding=1), nn.ReLU()]
            channels = width
    return layers


def _squeeze() -> list[nn.Module]:
    """SqueezeNet 1.1 (Iandola et al. 2016), to its last fire module."""
    layers: list[nn.Module] = [nn.Conv2d(3, 64, 3, stride=2), nn.ReLU()]
    channels = 64
    for fires in (((16, 64),) * 2, ((32, 128),) * 2, ((48, 192),) * 2 + ((64, 256),) * 2):
        layers.append(nn.MaxPool2d(3, 2, ceil_mode=True))
        for squeezed, expanded in fires:
            layers.append(Fire(channels, squeezed, expanded))
            channels = 2 * expanded
    return layers


BACKBONES = {
    "alex": (_alex, (1, 4, 7, 9, 11), (64, 192, 384, 256, 256), 31),
    "vgg": (_vgg, (3, 8, 15, 22, 29), (64, 128, 256, 512, 512), 16),
    "squeeze": (_squeeze, (1, 4, 7, 9, 10, 11, 12), (64, 128, 256, 384, 384, 512, 512), 17),
}
"""Name -> its layers, those whose output LPIPS compares, their channels, and the least side."""


class Lpips(nn.Module):
    """Distance of two images in the features of a backbone (Zhang et al. 2018, version 0.1).

    Args:
        net: a key of `BACKBONES`.

    Its weights are random until `read`.
    """

    def __init__(self, net: str) -> None:
        super().__init__()
        layers, self.compared, channels, self.least = BACKBONES[net]
        self.net = net
        self.features = nn.Sequential(*layers())
        self.heads = nn.ModuleList(nn.Conv2d(width, 1, 1, bias=False) for width in channels)
        self.register_buffer("shift", torch.tensor(SHIFT)[None, :, None, None])
        self.register_buffer("scale", torch.tensor(SCALE)[None, :, None, None])

    @classmethod
    def read(cls, net: str, weights: Path, heads: Path) -> Lpips:
        """The network with weights from files, on a GPU where there is one.

        Args:
            net: a key of `BACKBONES`.
            weights: state dict of torchvision's model, .pth or .safetensors.
            heads: those of the package `lpips`.

        Raises:
            ValueError: for files that do not hold its layers.
        """
        model = cls(net).eval().requires_grad_(False)
        _fill(model.features, _state(weights), "features.{}", weights, net)
        _fill(model.heads, _state(heads), "lin{}", heads, net, {".weight": ".model.1.weight"})
        return model.to("cuda" if torch.cuda.is_available() else "cpu")

    def forward(self, first: Tensor, second: Tensor, weights: Tensor | None = None) -> Tensor:
        """Distances of a batch.

        Args:
            first, second: (B, 3, h, w) in [-1, 1].
            weights: (B, 1, h, w) of the pixels, a layer's positions averaged by; None: all alike.

        Returns:
            (B,) distances.
        """
        pairs = (torch.cat([first, second]) - self.shift) / self.scale
        total = first.new_zeros(len(first))
        heads = iter(self.heads)
        for i, layer in enumerate(self.features):
            pairs = layer(pairs)
            if i in self.compared:
                unit = pairs / (pairs.square().sum(1, keepdim=True).sqrt() + EPSILON)
                a, b = unit.chunk(2)
                total = total + _mean(next(heads)((a - b).square()), weights)
        return total

    @torch.inference_mode()
    def distances(
        self, first: np.ndarray, second: np.ndarray, masks: np.ndarray | None = None
    ) -> np.ndarray:
        """Distances of images, in batches.

        Args:
            first, second: (T, h, w, 3) float32 in [0, 1].
            masks: (T, h, w) bool, the pixels that count; None for all.

        Returns:
            (T,) float64.

        Raises:
            ValueError: for images that are too small for the backbone.
        """
        height, width = first.shape[1:3]
        if min(height, width) < self.least:
            raise ValueError(
                f"LPIPS with net {self.net} needs images of {self.least} pixels or more, got "
                f"{width}x{height}"
            )
        device = self.shift.device
        batch = max(1, PIXELS[device.type] // (height * width))
        found = []
        for start in range(0, len(first), batch):
            part = slice(start, start + batch)
            a, b = (
                torch.from_numpy(np.ascontiguousarray(images[part], np.float32))
                .to(device)
                .permute(0, 3, 1, 2)
                * 2
                - 1
                for images in (first, second)
            )
            counted = None
            if masks is not None:
                counted = torch.from_numpy(masks[part].astype(np.float32))[:, None].to(device)
            found.append(self(a, b, counted).cpu().numpy())
        return np.concatenate(found).astype(np.float64)


def _mean(distance: Tensor, weights: Tensor | None) -> Tensor:
    """(B,) means of (B, 1, h, w) over positions, weighted by what (B, 1, H, W) holds of them."""
    if weights is None:
        return distance.mean((1, 2, 3))
    share = adaptive_avg_pool2d(weights, distance.shape[2:])
    return (distance * share).sum((1, 2, 3)) / share.sum((1, 2, 3))


def _state(path: Path) -> Mapping[str, Tensor]:
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    try:
        if path.suffix == ".safetensors":
            return load_file(path)
        return torch.load(path, map_location="cpu", weights_only=True)
    except (SafetensorError, UnpicklingError, RuntimeError, EOFError) as error:
        said = str(error).split("\n")[0]
        raise ValueError(f"{path}: not a readable file of weights ({said})") from error


def _fill(
    layers: nn.Module,
    state: Mapping[str, Tensor],
    named: str,
    path: Path,
    net: str,
    renamed: Mapping[str, str] | None = None,
) -> None:
    """Fill layers with tensors of a file, in which a layer has another name.

    Raises:
        ValueError: for tensors that are missing or of other shapes; all are named.
    """
    found, wrong = {}, []
    for key, tensor in layers.state_dict().items():
        number, _, rest = key.partition(".")
        there = f"{named.format(number)}{(renamed or {}).get(f'.{rest}', f'.{rest}')}"
        if there not in state:
            wrong.append(f"{there} is missing")
        elif state[there].shape != tensor.shape:
            shapes = tuple(state[there].shape), tuple(tensor.shape)
            wrong.append(f"{there} is {shapes[0]}, not {shapes[1]}")
        else:
            found[key] = state[there]
    if wrong:
        raise ValueError(f"{path}: no weights of LPIPS with net {net}: {'; '.join(wrong)}")
    layers.load_state_dict(found)
