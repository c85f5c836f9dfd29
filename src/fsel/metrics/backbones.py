"""Feature layers of AlexNet, VGG16 and SqueezeNet 1.1, and LPIPS on them; imports torch.

Layers are numbered as in torchvision's models, whose files of weights they read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import blake2b
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
        self._last: tuple[object, list[Tensor]] | None = None

    @classmethod
    def read(cls, net: str, weights: Path, heads: Path) -> Lpips:
        """The network with weights from files, on a GPU where there is one.

        Args:
            net: a key of `BACKBONES`.
            weights: state dict of torchvision's model, .pth or .safetensors.
            heads: those of the package `lpips`; the same file where it holds them.

        Raises:
            ValueError: for files that do not hold its layers.
        """
        model = cls(net).eval().requires_grad_(False)
        _fill(model.features, _state(weights), "features.{}", weights, net)
        _fill(model.heads, _state(heads), "lin{}", heads, net, {".weight": ".model.1.weight"})
        return model.to("cuda" if torch.cuda.is_available() else "cpu")

    def features_of(self, images: Tensor) -> list[Tensor]:
        """Unit feature vectors of the layers that are compared.

        Args:
            images: (B, 3, h, w) in [-1, 1].

        Returns:
            (B, C, h', w') of each layer, C of its own.
        """
        signal, layers = (images - self.shift) / self.scale, []
        for i, layer in enumerate(self.features):
            signal = layer(signal)
            if i in self.compared:
                # not `sqrt`, which is MKL's and ends in other digits on other processors
                length = torch.linalg.vector_norm(signal, dim=1, keepdim=True)
                layers.append(signal / (length + EPSILON))
        return layers

    def apart(
        self, first: Sequence[Tensor], second: Sequence[Tensor], weights: Tensor | None = None
    ) -> Tensor:
        """Distances of a batch from its features.

        Args:
            first, second: what `features_of` gives for each side.
            weights: (B, 1, h, w) of the pixels, a layer's positions averaged by; None: all alike.

        Returns:
            (B,) distances.
        """
        layers = zip(self.heads, first, second, strict=True)
        return torch.stack([_mean(head((a - b).square()), weights) for head, a, b in layers]).sum(0)

    @torch.inference_mode()
    def distances(
        self, images: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None
    ) -> np.ndarray:
        """Distances of images from the truth, in batches.

        Args:
            images: (T, h, w, 3) float32 in [0, 1].
            truth: (T, h, w, 3) uint8. Its features are kept where it is one batch.
            masks: (T, h, w) bool, the pixels that count; None for all.

        Returns:
            (T,) float64.

        Raises:
            ValueError: for images that are too small for the backbone.
        """
        height, width = images.shape[1:3]
        if min(height, width) < self.least:
            raise ValueError(
                f"LPIPS with net {self.net} needs images of {self.least} pixels or more, got "
                f"{width}x{height}"
            )
        batch = max(1, PIXELS[self.shift.device.type] // (height * width))
        if batch >= len(images):
            return self._batch(self._images(images), self._known(truth), masks)
        scores = []
        for start in range(0, len(images), batch):
            part = slice(start, start + batch)
            features = self.features_of(self._images(levels(truth[part])))
            own = masks[part] if masks is not None else None
            scores.append(self._batch(self._images(images[part]), features, own))
        return np.concatenate(scores)

    def _batch(
        self, images: Tensor, truth: Sequence[Tensor], masks: np.ndarray | None
    ) -> np.ndarray:
        counted = None
        if masks is not None:
            counted = torch.from_numpy(masks.astype(np.float32))[:, None].to(images.device)
        distances = self.apart(self.features_of(images), truth, counted)
        return distances.cpu().numpy().astype(np.float64)

    def _known(self, truth: np.ndarray) -> list[Tensor]:
        """Features of a truth, those of the last one kept."""
        key = truth.shape, blake2b(truth.tobytes()).digest()
        if self._last is None or self._last[0] != key:
            self._last = key, self.features_of(self._images(levels(truth)))
        return self._last[1]

    def _images(self, images: np.ndarray) -> Tensor:
        """(B, 3, h, w) in [-1, 1] of (B, h, w, 3) in [0, 1]."""
        own = torch.from_numpy(np.ascontiguousarray(images, np.float32)).to(self.shift.device)
        return own.permute(0, 3, 1, 2) * 2 - 1


def levels(truth: np.ndarray) -> np.ndarray:
    """Float32 in [0, 1] of uint8."""
    return truth.astype(np.float32) / 255


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
    kept, wrong = {}, []
    for key, tensor in layers.state_dict().items():
        number, _, rest = key.partition(".")
        there = f"{named.format(number)}{(renamed or {}).get(f'.{rest}', f'.{rest}')}"
        if there not in state:
            wrong.append(f"{there} is missing")
        elif state[there].shape != tensor.shape:
            shapes = tuple(state[there].shape), tuple(tensor.shape)
            wrong.append(f"{there} is {shapes[0]}, not {shapes[1]}")
        else:
            kept[key] = state[there]
    if wrong:
        raise ValueError(f"{path}: no weights of LPIPS with net {net}: {'; '.join(wrong)}")
    layers.load_state_dict(kept)
