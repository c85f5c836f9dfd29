"""Causes of a failed structure from motion, as the database of features and matches tells them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.colmap.bindings import pycolmap

FEW = 100  # features of an image, below which two images seldom share enough
INLIERS = 15  # of a verified pair
STILL = 0.005  # of the longer side that matches move: 2.4 pixels at 480
TURNS = 0.9  # share of the pairs that a rotation explains
DARK = (
    "its images show few features (the median is {count:.0f}): too dark, too blurred or without "
    "texture. Hint: more light, a slower walk"
)
STANDS = "the camera does not move. Hint: walk around what is to be seen"
ROTATES = "the camera turns on the spot. Hint: walk sideways, so that near things shift"
_TURNED = (
    pycolmap.TwoViewGeometryConfiguration.PANORAMIC,
    pycolmap.TwoViewGeometryConfiguration.PLANAR_OR_PANORAMIC,
)


def cause(database: Path) -> str:
    """Cause and hint in words; empty where the database tells none.

    Args:
        database: of COLMAP, with features and verified matches.
    """
    with pycolmap.Database.open(str(database)) as stored:
        images = stored.read_all_images()
        sides = {c.camera_id: max(c.width, c.height) for c in stored.read_all_cameras()}
        pixels = {i.image_id: stored.read_keypoints(i.image_id)[:, :2] for i in images}
        pairs, geometries = stored.read_two_view_geometries()
    count = float(np.median([len(xy) for xy in pixels.values()])) if pixels else 0.0
    if count < FEW:
        return DARK.format(count=count)
    side = {image.image_id: sides[image.camera_id] for image in images}
    moved, turned = [], []
    for pair, geometry in zip(pairs, geometries, strict=True):
        matches = geometry.inlier_matches
        if len(matches) >= INLIERS:
            first, second = pycolmap.pair_id_to_image_pair(pair)
            shift = pixels[first][matches[:, 0]] - pixels[second][matches[:, 1]]
            moved.append(np.median(np.hypot(*shift.T)) / side[first])
            turned.append(geometry.config in _TURNED)
    if not moved:
        return ""
    if np.percentile(moved, 90) < STILL:
        return STANDS
    return ROTATES if np.mean(turned) > TURNS else ""
