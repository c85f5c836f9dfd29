"""Recipes that find poses: what becomes of the cameras that MASt3R finds."""

import runpy

import cv2
import numpy as np
import pycolmap
from small_captures import ring

from fsel.captures.colmap.estimator import Estimator


def test_cameras_of_mast3r_are_of_the_whole_images(tmp_path):
    """480x253 became 512x270, of which seven rows above and below were cut."""
    files = [tmp_path / f"{row}.png" for row in range(6)]
    for file in files:
        cv2.imwrite(str(file), np.full((253, 480, 3), 99, np.uint8))
    matrix = np.array([[320.0, 0, 255.5], [0, 320, 127.5], [0, 0, 1]])
    world = [np.linalg.inv(np.vstack([pose, [0, 0, 0, 1]])) for pose in ring(6)]
    recipe = runpy.run_path(str(Estimator.recipes / "mast3r_sfm.py"))
    recipe["write"](tmp_path, files, [(256, 512)] * 6, [matrix] * 6, world)
    model = pycolmap.Reconstruction(str(tmp_path))
    images = sorted(model.images.values(), key=lambda image: image.name)
    assert [image.name for image in images] == [file.name for file in files]
    found = [image.cam_from_world().matrix() for image in images]
    np.testing.assert_allclose(found, ring(6), atol=1e-9)
    camera = images[0].camera
    assert (camera.model_name, camera.width, camera.height) == ("PINHOLE", 480, 253)
    np.testing.assert_allclose(camera.params, [300, 300, 240, 135 * 480 / 512])
