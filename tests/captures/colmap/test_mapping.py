"""Which of two models agrees with more of the verified matches."""

import numpy as np
import pycolmap
from small_captures import ring

from fsel.captures.colmap.failures import VerifiedPair
from fsel.captures.colmap.mapping import agreeing
from fsel.captures.colmap.model import build_model


def test_matches_agree_with_the_poses_they_were_seen_from():
    poses, points = ring(12)[:3], np.random.default_rng(0).uniform(-1, 1, (50, 3))
    camera = {"model": "SIMPLE_RADIAL", "width": 640, "height": 480}
    cameras = [pycolmap.Camera(**camera, params=[500, 320, 240, 0.05]) for _ in poses]
    local = [points @ pose[:, :3].T + pose[:, 3] for pose in poses]
    places = [camera.img_from_cam(xyz) / 640 for camera, xyz in zip(cameras, local, strict=True)]
    pairs = [
        VerifiedPair((i + 1, j + 1), (places[i], places[j]), False)
        for i, j in ((0, 1), (0, 2), (1, 2))
    ]

    def matches(poses):
        nothing, count = np.zeros((0, 3)), len(poses)
        names, none = [f"{i}.jpg" for i in range(count)], [np.zeros(0, int)] * count
        pixels = [np.zeros((0, 2))] * count
        model = build_model(names, cameras[:count], poses, nothing, nothing, none, pixels)
        return agreeing(model, pairs)

    assert matches(poses) == 150
    assert matches(poses[:2]) == 50  # the third was not placed
    poses[2, 1, 3] += 1
    assert 50 <= matches(poses) < 70
