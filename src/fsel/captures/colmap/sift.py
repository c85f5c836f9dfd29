"""SIFT by OpenCV for frames of a video: as many as a frame needs, spread over the image; and their
matches, by the search that COLMAP's exhaustive matcher makes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.images import files as image_files
from fsel.captures.images.masks import MASKS, load_white
from fsel.captures.images.previews import in_turn, reduced
from fsel.core.threads import side_by_side

MOST = 2000  # of an image: matching takes time with their square
SIDE = 640  # pixels of the longer side that they are found at, enlarged twice by SIFT itself
CELLS = 8  # along the longer side, each of which gives its strongest in turn
DRAWN = 3  # times as many that are detected before they are spread
LIT = 64  # grey levels of an image's contrast, below which the threshold is lowered
THRESHOLD, LEAST = 0.005, 0.0008  # of the contrast of a feature: a quarter of SIFT's, for walls
SCALED = 512  # COLMAP's bytes of a unit descriptor
# of the angle to the second nearest, and radians: COLMAP's 0.8 of the exact second, which its index
# often misses, places fewer frames of generated walks
RATIO, FARTHEST = 0.85, 0.7


def extract(database: Path, folder: Path, names: Sequence[str]) -> None:
    """Store the features of images that the database has, in white of their masks alone."""
    found = in_turn(lambda at: _masked(folder, names[at]), [folder / name for name in names])
    with pycolmap.Database.open(str(database)) as stored:
        keys = {image.name: image.image_id for image in stored.read_all_images()}
        for name, (points, descriptors) in zip(names, found, strict=True):
            kind = pycolmap.FeatureExtractorType.SIFT
            stored.write_descriptors(keys[name], pycolmap.FeatureDescriptors(kind, descriptors))
            stored.write_keypoints(keys[name], points)


def _masked(folder: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    mask = folder.with_name(MASKS) / f"{name}.png"
    white = load_white(mask) if mask.is_file() else None
    return find(image_files.load(folder / name), white)


def find(image: np.ndarray, white: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the features of an (h, w, 3) uint8 image, where an (h, w) bool mask is true.

    Returns:
        (n, 4) float32 x, y, scale and turn, in pixels and radians, and (n, 128) uint8 roots of
        descriptors (Arandjelovic and Zisserman 2012), as COLMAP stores them.
    """
    grey = cv2.cvtColor(reduced(image, SIDE), cv2.COLOR_RGB2GRAY)
    size = grey.shape[::-1]
    seen = (
        None if white is None else cv2.resize(np.uint8(white), size, interpolation=cv2.INTER_AREA)
    )
    low, high = np.percentile(grey, [1, 99])
    threshold = max(LEAST, THRESHOLD * min(1.0, (high - low) / LIT))
    sift = cv2.SIFT.create(DRAWN * MOST, contrastThreshold=threshold)
    found = sift.detect(grey, seen)
    if not found:
        return np.empty((0, 4), np.float32), np.empty((0, 128), np.uint8)
    places = np.array([one.pt for one in found])
    rows = spread(places, np.array([one.response for one in found]), max(grey.shape))
    kept, descriptors = sift.compute(grey, [found[row] for row in rows])
    scale = np.array(image.shape[1::-1]) / size
    pixels = (places[rows] + 0.5) * scale
    sizes = np.array([one.size / 2 for one in kept]) * scale[0]
    turns = np.radians([one.angle for one in kept])
    unit = descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    stored = np.minimum(np.rint(SCALED * np.sqrt(unit)), 255).astype(np.uint8)
    return np.column_stack([pixels, sizes, turns]).astype(np.float32), stored


def spread(places: np.ndarray, strength: np.ndarray, side: float) -> np.ndarray:
    """Return ascending rows of at most `MOST` of (n, 2) places in an image of a longer side, the
    (n,) strongest of each cell of a grid in turn."""
    cells = np.minimum(places * CELLS // side, CELLS - 1) @ [1, CELLS]
    order = np.lexsort((-strength, cells))
    first = np.searchsorted(cells[order], cells[order])
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order)) - first
    return np.sort(np.lexsort((-strength, rank))[:MOST])


def match(database: Path, pairs: Sequence[tuple[str, str]]) -> None:
    """Store matches of pairs of images, by name, that have none yet; they are to be verified."""
    with pycolmap.Database.open(str(database)) as stored:
        keys = {image.name: image.image_id for image in stored.read_all_images()}
        new = [(keys[one], keys[other]) for one, other in pairs]
        new = [pair for pair in new if not stored.exists_matches(*pair)]
        known = {key: stored.read_descriptors(key).data for key in set(chain(*new))}
        found = side_by_side(lambda pair: mutual(known[pair[0]], known[pair[1]]), new)
        for pair, rows in zip(new, found, strict=True):
            stored.write_matches(*pair, rows)


def mutual(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return (m, 2) uint32 rows of (n, 128) and (k, 128) uint8 descriptors that are each other's
    nearest and, by `RATIO`, clearly nearer than the second: what COLMAP's `cpu_brute_force_matcher`
    finds with that ratio."""
    if not min(len(one), len(other)):
        return np.empty((0, 2), np.uint32)
    likeness = one.astype(np.float32) @ other.T.astype(np.float32)  # exact: integers below 2^24
    rows, columns = np.arange(len(one)), likeness.argmax(axis=1)
    both = np.flatnonzero(likeness[rows, columns] == likeness.max(axis=0)[columns])
    columns, first = np.unique(columns[both], return_index=True)  # equal ones fail the ratio
    rows = both[first]
    best = _angles(likeness[rows, columns])
    likeness[rows, columns] = 0
    second = _angles(np.maximum(likeness.max(axis=1)[rows], likeness.max(axis=0)[columns]))
    clear = (best <= FARTHEST) & (best < RATIO * second)
    return np.column_stack([rows, columns])[clear].astype(np.uint32)


def _angles(products: np.ndarray) -> np.ndarray:
    return np.arccos(np.minimum(products / SCALED**2, 1))
