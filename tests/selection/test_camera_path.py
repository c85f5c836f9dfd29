"""Camera paths in files become views in the capture's world, or are refused by name."""

import json

import cv2
import numpy as np
import pytest
from small_captures import opengl, ring

from fsel.selection.targets import targets_of

TURNED = np.eye(4).tolist()


def test_a_camera_path_is_read_back_in_the_captures_world(circle, tmp_path):
    poses = ring(5)
    rotation = cv2.Rodrigues(np.array([0.3, -0.2, 0.9]))[0]
    transform = np.vstack([np.column_stack([rotation, [1.0, 2, 3]]), [0, 0, 0, 1]])
    stated = []
    for pose in poses:
        moved = transform @ opengl(pose)
        moved[:3, 3] *= 0.25
        stated.append({"camera_to_world": moved.ravel().tolist()})
    (tmp_path / "path.json").write_text(json.dumps({"camera_path": stated}))
    beside = {"transform": transform[:3].tolist(), "scale": 0.25}
    (tmp_path / "dataparser_transforms.json").write_text(json.dumps(beside))
    views = targets_of(circle, tmp_path / "path.json").views
    np.testing.assert_allclose(views.world_to_camera, poses, atol=1e-9)


def test_the_applied_transform_of_a_transforms_file_is_undone(circle, tmp_path):
    applied = np.array([[0.0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]])
    full = np.vstack([applied, [0, 0, 0, 1]])
    frames = [{"transform_matrix": (full @ opengl(pose)).tolist()} for pose in ring(5)]
    content = {"applied_transform": applied.tolist(), "frames": frames}
    (tmp_path / "p.json").write_text(json.dumps(content))
    views = targets_of(circle, tmp_path / "p.json").views
    np.testing.assert_allclose(views.world_to_camera, ring(5), atol=1e-9)


@pytest.mark.parametrize(
    ("key", "poses", "said"),
    [
        ("frames", [np.eye(4)[:3].tolist()] * 3 + [np.eye(4)[:, :3].tolist()], "must be 4x4"),
        ("camera_path", [TURNED, np.zeros((4, 4)).tolist()], r"'camera_path\[1\]': rotation has"),
        ("camera_path", [TURNED, [[1e400] * 4] * 4], r"camera_path\[1\] must be finite"),
        ("camera_path", [[1, 2]], r"camera_to_world of camera_path\[0\]"),
        ("frames", [None], "field 'transform_matrix' is missing"),
        ("views", [TURNED], "expected a list `camera_path`"),
    ],
)
def test_a_path_holds_poses_that_are_rigid_motions(key, poses, said, circle, tmp_path):
    field = "camera_to_world" if key == "camera_path" else "transform_matrix"
    (tmp_path / "p.json").write_text(json.dumps({key: [{field: pose} for pose in poses]}))
    with pytest.raises(ValueError, match=said) as error:
        targets_of(circle, tmp_path / "p.json")
    assert "p.json" in str(error.value)


def test_four_poses_of_three_rows_are_four_views(circle, tmp_path):
    rows = [{"transform_matrix": pose[:3]} for pose in [TURNED] * 4]
    (tmp_path / "p.json").write_text(json.dumps({"frames": rows}))
    assert len(targets_of(circle, tmp_path / "p.json").views) == 4


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scale": None}, "field 'scale' is missing"),
        ({"scale": 0}, "scale is 0; allowed: more than 0"),
        ({"transform": [[0] * 4] * 3}, "transform cannot be"),
    ],
)
def test_a_damaged_transform_beside_a_path_is_named(change, said, circle, tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"camera_path": [{"camera_to_world": TURNED}]}))
    stated = {"scale": 1.0, "transform": TURNED[:3]} | change
    (tmp_path / "dataparser_transforms.json").write_text(json.dumps(stated))
    with pytest.raises(ValueError, match=rf"dataparser_transforms\.json: {said}"):
        targets_of(circle, tmp_path / "p.json")
