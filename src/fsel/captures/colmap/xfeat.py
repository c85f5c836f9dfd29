"""XFeat (Potje et al. 2024): keypoints and descriptors by a small network, in NumPy.

Its convolutions take some tenths of a second an image of 640 pixels on one core, so that neither
torch nor a GPU is needed.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from fsel.captures.colmap.layers import EPSILON, convolved

SIDE = 1024  # pixels of the longer side of what the network sees, at most
STEP = 32  # both sides are multiples of
CELL = 8  # pixels of the side of what one descriptor of the map shows
MOST = 2048  # keypoints of an image
LEAST = 0.05  # probability of a keypoint
APART = np.ones((5, 5), np.uint8)  # pixels around a keypoint, in which none is likelier
ALIKE = 0.82  # cosine of descriptors that are matched, at least, as the authors'
RATIO = 0.95  # of the nearest descriptor's distance to the second nearest's, at most
BLOCKS = {
    "block1": 4,
    "block2": 2,
    "block3": 3,
    "block4": 3,
    "block5": 4,
    "block_fusion": 3,
    "heatmap_head": 3,
    "keypoint_head": 4,
}
"""Block -> number of its convolutions, all but three with a ReLU behind them."""
HALVING = ("block1.1", "block1.3", "block3.0", "block4.0", "block5.0")
LINEAR = ("block_fusion.2", "heatmap_head.2", "keypoint_head.3")

Features = tuple[np.ndarray, np.ndarray]
"""(n, 2) float32 pixels, top-left centre at (0.5, 0.5), and (n, 64) float32 unit descriptors."""


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


class XFeat:
    """The network.

    Attributes:
        state: layer -> float32 weights and bias, normalisations folded into them; see `folded`.
    """

    def __init__(self, state: Mapping[str, np.ndarray]) -> None:
        self.state = state

    def __call__(self, image: np.ndarray) -> Features:
        """Keypoints of an (h, w, 3) uint8 image, the surest first, 2048 at most."""
        height, width = image.shape[:2]
        scale = min(1.0, SIDE / max(height, width))
        size = [max(STEP, int(side * scale) // STEP * STEP) for side in (width, height)]
        grey = cv2.resize(image, size, interpolation=cv2.INTER_AREA).mean(axis=2, dtype=np.float32)
        descriptors, likely, reliable = self._maps(grey)
        peak = (likely == cv2.dilate(likely, APART)) & (likely > LEAST)
        rows, columns = np.nonzero(peak)
        at = np.stack([columns, rows], axis=1).astype(np.float32)
        score = likely[rows, columns] * _sampled(reliable, at, size, cv2.INTER_LINEAR)[:, 0]
        best = np.argsort(-score, kind="stable")[:MOST]
        best = best[score[best] > 0]
        found = _sampled(descriptors, at[best], size, cv2.INTER_CUBIC)
        found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
        finer = at[best] + _within_pixels(likely, rows[best], columns[best])
        return (finer + 0.5) * np.array([width / size[0], height / size[1]], np.float32), found

    def _maps(self, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(h/8, w/8, 64) descriptors, (h, w) likely keypoints, (h/8, w/8, 1) sure descriptors."""
        image = ((grey - grey.mean()) / np.sqrt(grey.var() + EPSILON))[None]
        quarter = cv2.resize(image[0], None, fx=1 / 4, fy=1 / 4, interpolation=cv2.INTER_AREA)
        skipped = self._convolved(quarter[None], "skip1.1")
        third = self._block(self._block(self._block(image, "block1") + skipped, "block2"), "block3")
        fourth = self._block(third, "block4")
        fifth = self._block(fourth, "block5")
        fused = self._block(third + _enlarged(fourth, 2) + _enlarged(fifth, 4), "block_fusion")
        reliable = 1 / (1 + np.exp(-self._block(fused, "heatmap_head")))
        _, high, wide = third.shape
        cells = image.reshape(high, CELL, wide, CELL).transpose(1, 3, 0, 2).reshape(-1, high, wide)
        raised = np.exp(self._block(cells, "keypoint_head"))
        likely = (raised / raised.sum(axis=0))[:-1].reshape(CELL, CELL, high, wide)
        likely = likely.transpose(2, 0, 3, 1).reshape(grey.shape)
        return fused.transpose(1, 2, 0), likely, reliable.transpose(1, 2, 0)

    def _block(self, image: np.ndarray, name: str) -> np.ndarray:
        for at in range(BLOCKS[name]):
            image = self._convolved(image, layer := f"{name}.{at}")
            if layer not in LINEAR:
                np.maximum(image, 0, out=image)
        return image

    def _convolved(self, image: np.ndarray, layer: str) -> np.ndarray:
        """(c, h, w) of (b, h, w), or of half the sides."""
        weight, bias = (self.state[f"{layer}.{part}"] for part in ("weight", "bias"))
        return convolved(image, weight, bias, 2 if layer in HALVING else 1)


def _enlarged(image: np.ndarray, times: int) -> np.ndarray:
    size = image.shape[2] * times, image.shape[1] * times
    return np.stack([cv2.resize(one, size, interpolation=cv2.INTER_LINEAR) for one in image])


def _sampled(maps: np.ndarray, at: np.ndarray, size: list[int], how: int) -> np.ndarray:
    """(n, c) values of (h/8, w/8, c) maps at (n, 2) pixels of the image."""
    if not len(at):
        return np.zeros((0, maps.shape[2]), np.float32)
    # the authors' interpolation, which the network was trained with
    scale = np.array(maps.shape[1::-1], np.float32) / (np.array(size, np.float32) - 1)
    places = at * scale - np.float32(0.5)
    four = (np.ascontiguousarray(maps[..., i : i + 4]) for i in range(0, maps.shape[2], 4))
    edge = cv2.BORDER_CONSTANT
    found = [cv2.remap(one, places[None], None, how, borderMode=edge) for one in four]
    return np.concatenate([part.reshape(len(at), -1) for part in found], axis=1)


def _within_pixels(likely: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(n, 2) offsets in x and y, half a pixel at most, of the peaks of parabolas at pixels."""
    padded = np.pad(likely, 1, mode="edge")
    middle = likely[rows, columns]
    offsets = []
    for x, y in ((1, 0), (0, 1)):
        before = padded[rows + 1 - y, columns + 1 - x]
        behind = padded[rows + 1 + y, columns + 1 + x]
        offsets.append((behind - before) / (2 * np.maximum(2 * middle - before - behind, 1e-12)))
    return np.clip(np.stack(offsets, axis=1), -0.5, 0.5)


def matches(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(m, 2) uint32 rows of descriptors that are each other's nearest, alike, and like no other.

    Mutual neighbours alone, as the authors match them, let wrong pairs of images through the
    verification: three in four, of images far apart.
    """
    if min(len(one), len(other)) < 2:
        return np.zeros((0, 2), np.uint32)
    there, least, near = _nearest(one, other)
    back, _, again = _nearest(other, one)
    rows = np.arange(len(one))
    farther = np.minimum(near, again[there])
    kept = (back[there] == rows) & (least < 2 - 2 * ALIKE) & (least < RATIO**2 * farther)
    return np.stack([rows[kept], there[kept]], axis=1).astype(np.uint32)


def _nearest(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nearest other of each descriptor, its squared distance, and the second nearest's."""
    cosine = one @ other.T
    rows, there = np.arange(len(one)), cosine.argmax(axis=1)
    best = cosine[rows, there]
    cosine[rows, there] = -1
    return there, 2 - 2 * best, 2 - 2 * cosine.max(axis=1)
