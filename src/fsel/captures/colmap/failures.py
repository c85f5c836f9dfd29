"""Causes of a failed structure from motion, as the database of features and matches tells them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.core.subsets import evenly

FEW = 100  # features of an image, below which two images seldom share enough
INLIERS = 15  # of a verified pair
STILL = 0.005  # of the longer side that matches move: 2.4 pixels at 480
TURNS = 0.9  # share of the pairs that a rotation explains
MOVED = 0.02  # of the longer side, of pairs that tell whether a picture slides
RIGID = 0.0025  # of the longer side, left of 90 % of the matches where they move as a whole
PAIRS, SAMPLE = 10, 200  # least, and most, pairs that tell it
DARK = (
    "its images show few features (the median is {count:.0f}): too dark, too blurred or without "
    "texture. Hint: more light, a slower walk; or --features aliked, which takes longer"
)
STANDS = "the camera does not move. Hint: walk around what is to be seen"
ROTATES = "the camera turns on the spot. Hint: walk sideways, so that near things shift"
SLIDES = (
    "its images are pieces of one picture that slides, without depth. Hint: film a scene, walking "
    "around it"
)
_TURNED = (
    pycolmap.TwoViewGeometryConfiguration.PANORAMIC,
    pycolmap.TwoViewGeometryConfiguration.PLANAR_OR_PANORAMIC,
)


def cause(database: Path) -> str:
    """Return the cause and hint in words; empty where COLMAP's database tells none."""
    with pycolmap.Database.open(str(database)) as stored:
        counts = [len(stored.read_keypoints(i.image_id)) for i in stored.read_all_images()]
    count = float(np.median(counts)) if counts else 0.0
    if count < FEW:
        return DARK.format(count=count)
    pairs = _verified(database)
    if not pairs:
        return ""
    moved = [np.median(np.hypot(*(one - other).T)) for one, other, _ in pairs]
    if np.percentile(moved, 90) < STILL:
        return STANDS
    return ROTATES if np.mean([turned for *_, turned in pairs]) > TURNS else ""


def slides(database: Path) -> bool:
    """Return whether the images are pieces of one picture: all matches of a pair move as a whole.

    COLMAP tries for minutes to place such images, and what it places has no depth. Real scenes are
    far from it: under a drone, 0.5 % of the longer side is left where 0.15 % is of one picture.
    """
    pairs, left = _verified(database), []
    pairs = [pair for pair in pairs if np.median(np.hypot(*(pair[0] - pair[1]).T)) > MOVED]
    for one, other, _ in (pairs[at] for at in evenly(len(pairs), SAMPLE)):
        similar, _ = cv2.estimateAffinePartial2D(one, other, method=cv2.LMEDS)
        moved = one if similar is None else one @ similar[:, :2].T + similar[:, 2]
        left.append(np.percentile(np.hypot(*(moved - other).T), 90))
    return len(left) >= PAIRS and float(np.median(left)) < RIGID


def _verified(database: Path) -> list[tuple[np.ndarray, np.ndarray, bool]]:
    """Verified pairs: (m, 2) matched places in both, in longer sides; whether a rotation explains
    them."""
    with pycolmap.Database.open(str(database)) as stored:
        sides = {c.camera_id: max(c.width, c.height) for c in stored.read_all_cameras()}
        places = {
            i.image_id: stored.read_keypoints(i.image_id)[:, :2] / sides[i.camera_id]
            for i in stored.read_all_images()
        }
        found = []
        for pair, geometry in zip(*stored.read_two_view_geometries(), strict=True):
            matches = geometry.inlier_matches
            if len(matches) >= INLIERS:
                first, second = pycolmap.pair_id_to_image_pair(pair)
                one, other = places[first][matches[:, 0]], places[second][matches[:, 1]]
                found.append((one, other, geometry.config in _TURNED))
    return found
