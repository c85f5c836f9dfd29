"""Causes of a failed structure from motion, as the database of features and matches tells them."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

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
STANDS = "the camera does not move. Hint: walk around the subject"
ROTATES = "the camera only rotates. Hint: walk sideways, so that near things shift"
SLIDES = (
    "its images are sections of one flat picture, without depth. Hint: film a scene, walking "
    "around it"
)
_TURNED = (
    pycolmap.TwoViewGeometryConfiguration.PANORAMIC,
    pycolmap.TwoViewGeometryConfiguration.PLANAR_OR_PANORAMIC,
)


class VerifiedPair(NamedTuple):
    """Two images and their verified matches."""

    images: tuple[int, int]  # their numbers in the database
    places: tuple[np.ndarray, np.ndarray]  # (m, 2) of the matches in both, in longer sides
    turned: bool  # whether a rotation explains them


def cause(database: Path) -> str:
    """Return the cause and hint in words; empty where COLMAP's database tells none."""
    with pycolmap.Database.open(str(database)) as stored:
        counts = [len(stored.read_keypoints(i.image_id)) for i in stored.read_all_images()]
    count = float(np.median(counts)) if counts else 0.0
    if count < FEW:
        return DARK.format(count=count)
    pairs = verified_pairs(database)
    if not pairs:
        return ""
    moved = [_moved(pair) for pair in pairs]
    if np.percentile(moved, 90) < STILL:
        return STANDS
    return ROTATES if np.mean([pair.turned for pair in pairs]) > TURNS else ""


def slides(database: Path) -> bool:
    """Return whether all matches of a pair move as a whole: images that are pieces of one picture,
    which COLMAP tries for minutes to place, without depth."""
    pairs, left = verified_pairs(database), []
    pairs = [pair for pair in pairs if _moved(pair) > MOVED]
    for one, other in (pairs[at].places for at in evenly(len(pairs), SAMPLE)):
        similar, _ = cv2.estimateAffinePartial2D(one, other, method=cv2.LMEDS)
        moved = one if similar is None else one @ similar[:, :2].T + similar[:, 2]
        left.append(np.percentile(np.hypot(*(moved - other).T), 90))
    return len(left) >= PAIRS and float(np.median(left)) < RIGID


def _moved(pair: VerifiedPair) -> float:
    return float(np.median(np.hypot(*(pair.places[0] - pair.places[1]).T)))


def verified_pairs(database: Path) -> list[VerifiedPair]:
    """Return the pairs of images whose matches COLMAP verified."""
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
                images = pycolmap.pair_id_to_image_pair(pair)
                one, other = (places[key][matches[:, at]] for at, key in enumerate(images))
                found.append(VerifiedPair(images, (one, other), geometry.config in _TURNED))
    return found
