"""Recipes that find poses: GLOMAP itself, and what becomes of the cameras that MASt3R finds."""

import runpy
import sys
from pathlib import Path

import cv2
import numpy as np
import pycolmap
from small_captures import ring

from fsel.captures.colmap.estimator import Estimator
from fsel.captures.colmap.runs import Work
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm

sys.path.insert(0, str(Path(__file__).parents[1]))


def test_glomap_places_the_frames_of_textured_planes(tmp_path):
    from test_sfm import aligned_error, poses, render

    names = [f"{row}.png" for row in range(8)]
    for name, image in zip(names, render(poses(8)), strict=True):
        cv2.imwrite(str(tmp_path / name), image[:, :, ::-1])
    raw = bare.of_files(names, [tmp_path / name for name in names])
    glomap = Estimator(by=[sys.executable, "{recipes}/glomap.py", "{folder}", "num_threads=1"])
    found = sfm.reconstruct(raw, Work(tmp_path / "w", by=glomap))
    assert found.names == names
    assert aligned_error(found.world_to_camera, poses(8)) < 0.05
    assert len(found.points(range(8)).xyz) > 50


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
