"""Recipes that find poses: GLOMAP itself, and stand-ins for what the others call."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from small_captures import ring

from fsel.captures.colmap.estimator import Estimator
from fsel.captures.colmap.runs import Work
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm

sys.path.insert(0, str(Path(__file__).parents[1]))

# MASt3R's modules, by path: cameras of a ring, as they are in images made smaller and cut
MAST3R = {
    "mast3r/utils/path_to_dust3r.py": "",
    "mast3r/model.py": """
class AsymmetricMASt3R:
    @classmethod
    def from_pretrained(cls, weights):
        assert weights == "mine.pth"
        return cls()
    def to(self, device):
        return self
""",
    "dust3r/utils/image.py": """
import numpy as np
def load_images(files, size):
    assert size == 512 and files == sorted(files)
    return [{"true_shape": np.int32([[256, 512]])} for file in files]
""",
    "dust3r/image_pairs.py": """
def make_pairs(images, scene_graph, prefilter, symmetrize):
    assert (scene_graph, prefilter, symmetrize) == ("swin-3", None, True)
    return "pairs"
""",
    "mast3r/cloud_opt/sparse_ga.py": """
from types import SimpleNamespace
import numpy as np, torch
def sparse_global_alignment(files, pairs, cache, model, device):
    assert pairs == "pairs"
    poses = np.concatenate([np.load("../ring.npy"), np.tile([[[0, 0, 0, 1.0]]], (6, 1, 1))], axis=1)
    world = torch.from_numpy(np.linalg.inv(poses))
    matrix = torch.tensor([[320.0, 0, 255.5], [0, 320, 127.5], [0, 0, 1]])
    return SimpleNamespace(intrinsics=[matrix] * 6, get_im_poses=lambda: world)
""",
}


@pytest.fixture
def photos(tmp_path):
    """Six grey photos whose long side is made larger, and short one cut, by MASt3R."""
    folder = tmp_path / "photos"
    folder.mkdir()
    for row in range(6):
        cv2.imwrite(str(folder / f"{row}.png"), np.full((253, 480, 3), 99, np.uint8))
    return bare.read(folder)


def placed(raw, folder, *words, **settings):
    estimator = Estimator(by=[sys.executable, *words], **settings)
    return sfm.reconstruct(raw, Work(folder, by=estimator))


def test_glomap_places_the_frames_of_textured_planes(tmp_path):
    from test_sfm import aligned_error, poses, render

    names = [f"{row}.png" for row in range(8)]
    for name, image in zip(names, render(poses(8)), strict=True):
        cv2.imwrite(str(tmp_path / name), image[:, :, ::-1])
    raw = bare.of_files(names, [tmp_path / name for name in names])
    found = placed(raw, tmp_path / "w", "{recipes}/glomap.py", "{folder}", "num_threads=1")
    assert found.names == names
    assert aligned_error(found.world_to_camera, poses(8)) < 0.05
    assert len(found.points(range(8)).xyz) > 50


def test_cameras_of_mast3r_are_of_the_whole_images(photos, tmp_path):
    np.save(tmp_path / "ring.npy", ring(6))
    for name, text in MAST3R.items():
        path = tmp_path / "repository" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    words = ("{recipes}/mast3r_sfm.py", "{folder}", str(tmp_path / "repository"), "mine.pth")
    found = placed(photos, tmp_path / "w", *words, "swin-3")
    np.testing.assert_allclose(found.world_to_camera, ring(6), atol=1e-9)
    # 480x253 became 512x270, of which seven rows above and below were cut
    assert found.cameras[0].model == "PINHOLE"
    np.testing.assert_allclose(found.cameras[0].params, [300, 300, 240, 135 * 480 / 512])
    assert found.points(range(6)) is None
