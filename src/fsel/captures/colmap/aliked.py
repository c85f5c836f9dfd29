"""ALIKED (Zhao et al. 2023): keypoints and descriptors by a deformable network, in NumPy."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from fsel.captures.colmap.layers import EPSILON, convolved, deformed, sampled, selu, sigmoid

SIDE = 1024  # pixels of the longer side of what the network sees, at most
STEP = 32  # both sides are padded to multiples of
MOST = 512  # keypoints of an image: the time of a pair grows with their square
LEAST = 0.1  # score of a keypoint, half of the authors': images that show little have more
RADIUS = 2  # pixels around a keypoint, in which none scores higher
AROUND = np.ones((2 * RADIUS + 1, 2 * RADIUS + 1), np.uint8)
WITHIN = np.stack(np.meshgrid(*[np.arange(-RADIUS, RADIUS + 1)] * 2), axis=-1).reshape(-1, 2)
CONTRAST = np.float32(0.6)  # of an image, at least: the network was not trained in the dark
TEMPERATURE = 0.1  # of the mean of places around a peak

Features = tuple[np.ndarray, np.ndarray]
"""(n, 2) float32 pixels, top-left centre at (0.5, 0.5), and (n, 128) float32 unit descriptors."""


def folded(state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Layers of the authors' file, the normalisations folded into the convolutions before them."""
    layers = {name: value for name, value in state.items() if ".bn" not in name}
    for name in (name for name in state if name.endswith(".running_mean")):
        norm = name.removesuffix(".running_mean")
        gain = state[f"{norm}.weight"] / np.sqrt(state[f"{norm}.running_var"] + np.float32(EPSILON))
        layer = norm.replace("bn", "conv")
        if f"{layer}.weight" not in state:
            layer += ".regular_conv"
        layers[f"{layer}.weight"] = state[f"{layer}.weight"] * gain[:, None, None, None]
        layers[f"{layer}.bias"] = state[f"{norm}.bias"] - state[name] * gain
    return layers


class Aliked:
    """The network `aliked-n16`.

    Attributes:
        state: layer -> float32 weights and biases; see `folded`.
    """

    def __init__(self, state: Mapping[str, np.ndarray]) -> None:
        self.state = state

    def __call__(self, image: np.ndarray) -> Features:
        """Keypoints of an (h, w, 3) uint8 image, the surest first, 512 at most."""
        height, width = image.shape[:2]
        scale = min(1.0, SIDE / max(height, width))
        size = [max(STEP, round(side * scale)) for side in (width, height)]
        seen = _lit(cv2.resize(image, size, interpolation=cv2.INTER_AREA) / np.float32(255))
        maps, likely = self._maps(np.moveaxis(seen, 2, 0))
        at = keypoints(likely)
        descriptors = self._described(maps, at)
        return (at + 0.5) * np.array([width / size[0], height / size[1]], np.float32), descriptors

    def _maps(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(128, h, w) features of unit length, and (h, w) scores, of a (3, h, w) image."""
        lacks = [-side % STEP for side in image.shape[1:]]
        edges = [(lack // 2, lack - lack // 2) for lack in lacks]
        levels = [self._block(np.pad(image, [(0, 0), *edges], mode="edge"), "block1")]
        for at, times in ((2, 2), (3, 4), (4, 4)):
            levels.append(self._block(_smaller(levels[-1], times), f"block{at}"))
        size = levels[0].shape[1:]
        levels = [selu(self._layer(level, f"conv{at}")) for at, level in enumerate(levels, 1)]
        maps = np.concatenate([_enlarged(level, *size) for level in levels])
        likely = maps
        for at in (0, 2, 4):
            likely = selu(self._layer(likely, f"score_head.{at}"))
        likely = sigmoid(self._layer(likely, "score_head.6"))
        maps /= np.maximum(np.sqrt(np.einsum("chw,chw->hw", maps, maps)), 1e-12)
        rows, columns = (slice(a, side - b) for (a, b), side in zip(edges, size, strict=True))
        return maps[:, rows, columns], likely[0, rows, columns]

    def _block(self, image: np.ndarray, name: str) -> np.ndarray:
        out = self._layer(selu(self._layer(image, f"{name}.conv1")), f"{name}.conv2")
        if f"{name}.downsample.weight" in self.state:
            out += self._layer(image, f"{name}.downsample")
        return selu(out)

    def _layer(self, image: np.ndarray, name: str) -> np.ndarray:
        if f"{name}.offset_conv.weight" in self.state:
            most = max(image.shape[1:]) / 4
            offsets = np.clip(self._layer(image, f"{name}.offset_conv"), -most, most)
            name += ".regular_conv"
            return deformed(
                image, offsets, self.state[f"{name}.weight"], self.state[f"{name}.bias"]
            )
        bias = self.state.get(f"{name}.bias", np.zeros(1, np.float32))
        return convolved(image, self.state[f"{name}.weight"], bias)

    def _described(self, maps: np.ndarray, at: np.ndarray) -> np.ndarray:
        """(n, 128) descriptors of features at 16 places around each of (n, 2) pixels."""
        _, high, wide = maps.shape
        x, y = np.clip(at.astype(np.intp) - 1, 0, [wide - 4, high - 4]).T[..., None]
        down, right = np.divmod(np.arange(9), 3)
        taps = self.state["desc_head.offset_conv.0.weight"].reshape(-1, len(maps), 9)
        near = np.tensordot(taps, maps[:, y + down, x + right], axes=((1, 2), (0, 2)))
        near = selu(near + self.state["desc_head.offset_conv.0.bias"][:, None])
        offsets = self.state["desc_head.offset_conv.2.weight"][..., 0, 0] @ near
        most = max(high, wide) / 4
        offsets = np.clip(
            offsets + self.state["desc_head.offset_conv.2.bias"][:, None], -most, most
        )
        right_by, down_by = offsets.reshape(2, len(offsets) // 2, len(at))
        found = sampled(maps, at[:, 1] + down_by, at[:, 0] + right_by)
        found = selu(np.tensordot(self.state["desc_head.sf_conv.weight"][..., 0, 0], found, axes=1))
        out = np.tensordot(found, self.state["desc_head.agg_weights"], axes=((0, 1), (1, 0)))
        return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)


def keypoints(likely: np.ndarray) -> np.ndarray:
    """(n, 2) float32 x and y of the peaks of (h, w) scores, the highest first."""
    peak = likely == cv2.dilate(likely, AROUND)
    for _ in range(2):  # peaks of what no peak is near
        near = cv2.dilate(peak.astype(np.uint8), AROUND) > 0
        rest = np.where(near, 0, likely)
        peak |= (rest == cv2.dilate(rest, AROUND)) & ~near
    score = np.zeros_like(likely)
    inner = (slice(RADIUS, -RADIUS),) * 2
    score[inner] = np.where(peak, likely, 0)[inner]
    least = LEAST if (score > LEAST).any() else likely.mean()
    rows, columns = np.nonzero(score > least)
    best = np.argsort(-score[rows, columns], kind="stable")[:MOST]
    rows, columns = rows[best], columns[best]
    around = np.lib.stride_tricks.sliding_window_view(likely, AROUND.shape)
    around = around[rows - RADIUS, columns - RADIUS].reshape(-1, AROUND.size)
    raised = np.exp((around - around.max(axis=1, keepdims=True)) / TEMPERATURE)
    finer = raised @ WITHIN / raised.sum(axis=1, keepdims=True)
    return (np.stack([columns, rows], axis=1) + finer).astype(np.float32)


def _lit(image: np.ndarray) -> np.ndarray:
    """An image whose contrast, that of all values but 1 % at each end, is raised to the least."""
    low, high = np.percentile(image, [1, 99]).astype(np.float32)
    gain = CONTRAST / max(high - low, 1 / 255)
    return image if gain <= 1 else np.clip((image - low) * gain, 0, 1)


def _smaller(image: np.ndarray, times: int) -> np.ndarray:
    count, high, wide = image.shape
    return image.reshape(count, high // times, times, wide // times, times).mean(axis=(2, 4))


def _enlarged(image: np.ndarray, high: int, wide: int) -> np.ndarray:
    """An image between its own pixels, the outermost of which stay the outermost."""
    down, right = (_between(a, b) for a, b in zip(image.shape[1:], (high, wide), strict=True))
    return down @ image @ right.T


def _between(few: int, many: int) -> np.ndarray:
    """(many, few) shares of few values in many between them."""
    places = np.linspace(0, few - 1, many)[:, None]
    return np.maximum(1 - np.abs(places - np.arange(few)), 0).astype(np.float32)
