"""Poses from images, points from poses: on textured planes whose truth is known."""

import json
import shutil
import sqlite3
from contextlib import closing

import cv2
import numpy as np
import pycolmap
import pytest
from layout_recordings import full
from scipy.spatial.transform import Rotation
from selection_problems import around
from small_captures import opengl

from fsel.captures.colmap import runs
from fsel.captures.colmap.model import enlarge, write_model
from fsel.captures.colmap.runs import Part, Work
from fsel.captures.images import files as image_files
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm
from fsel.captures.poses.sfm import neighbours
from fsel.captures.read import read_capture, read_folder

SIZE = (240, 180)
K = np.array([[225.0, 0, 120], [0, 225.0, 90], [0, 0, 1]])
PLANES = ((0.0, 6.0, 9.0), (-1.6, 4.0, 2.2), (1.7, 4.8, 2.2))  # centre x, depth, extent


def poses(count=10):
    """Cameras on an arc, turned a little towards the middle."""
    out = []
    for at in np.linspace(-1, 1, count):
        rotation = Rotation.from_euler("y", 8 * at, degrees=True).as_matrix()
        center = np.array([1.2 * at, 0.25 * np.sin(5 * at), 0.3 * at**2])
        out.append(np.column_stack([rotation, -rotation @ center]))
    return np.array(out)


def render(world_to_camera, seed=0):
    """(N, h, w, 3) uint8: planes facing the cameras, far to near, each with its own texture."""
    rng = np.random.default_rng(seed)
    textures = []
    for _ in PLANES:
        coarse = rng.integers(0, 255, (40, 40, 3), dtype=np.uint8)
        textures.append(cv2.resize(coarse, (600, 600), interpolation=cv2.INTER_LINEAR))
    out = []
    for pose in world_to_camera:
        image = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
        for (x, z, extent), texture in zip(PLANES, textures, strict=True):
            # texture pixel (u, v) lies at (x + (u - 300) s, (v - 300) s, z)
            s = extent / 600
            plane = np.array([[s, 0, x - 300 * s], [0, s, -300 * s], [0, 0, z], [0, 0, 1]])
            warp = K @ (pose @ plane)
            shown = cv2.warpPerspective(texture, warp, SIZE)
            there = cv2.warpPerspective(np.ones((600, 600), np.uint8), warp, SIZE)
            image[there > 0] = shown[there > 0]
        out.append(image)
    return np.stack(out)


def write_posed(folder, truth):
    """transforms.json without points; pixel centres at (0.5, 0.5)."""
    names = [f"{i}.png" for i in range(len(truth))]
    image_files.write(render(truth), folder / "images", names)
    frames = [
        {"file_path": f"images/{name}", "transform_matrix": opengl(pose).tolist()}
        for name, pose in zip(names, truth, strict=True)
    ]
    content = {"w": 240, "h": 180, "fl_x": 225, "fl_y": 225, "cx": 120.5, "cy": 90.5}
    (folder / "transforms.json").write_text(json.dumps(content | {"frames": frames}))


def aligned_error(found, truth):
    """Greatest distance of camera centres after the best similarity, over their extent."""
    a = np.array([full(pose)[:3, 3] for pose in found])
    b = np.array([full(pose)[:3, 3] for pose in truth])
    fit = pycolmap.estimate_sim3d(a, b)
    moved = np.array([fit * center for center in a])
    return np.linalg.norm(moved - b, axis=1).max() / np.linalg.norm(np.ptp(b, axis=0))


def test_points_are_triangulated_onto_the_surfaces_the_same_again(tmp_path):
    write_posed(tmp_path, poses(6))
    assert read_capture(tmp_path, long_side=64).points is None
    points, again = (
        read_capture(tmp_path, long_side=64, points="triangulate").points for _ in range(2)
    )
    for field in ("xyz", "rgb", "track_point", "track_frame"):
        np.testing.assert_array_equal(getattr(again, field), getattr(points, field))
    assert len(points.xyz) > 200
    depths = np.array([z for _, z, _ in PLANES])
    off = np.abs(points.xyz[:, 2:] - depths).min(axis=1)
    assert np.median(off) < 0.02
    assert np.percentile(off, 90) < 0.2
    assert np.bincount(points.track_point).min() >= 2


@pytest.mark.parametrize("parts", [(), [Part(range(5), ordered=True)]])
def test_features_and_matches_are_the_same_on_any_number_of_threads(parts, tmp_path, monkeypatch):
    names, content = [f"00_{i}.png" if parts else f"{i}.png" for i in range(5)], []
    work = Work(parts=parts)
    shown = render(poses(5))
    shown[2] //= 4  # features of dim images are looked for apart
    image_files.write(shown, tmp_path, names)
    for count in (1, 2):
        monkeypatch.setenv("FSEL_THREADS", str(count))
        database = tmp_path / f"{count}.db"
        runs.extract(database, tmp_path, names, work)
        runs.match(database, names, work)
        with closing(sqlite3.connect(database)) as stored:
            content.append(list(stored.iterdump()))
    assert content[0] == content[1]
    assert sum("two_view_geometries" in line for line in content[0]) > 10


def test_a_gpu_is_used_where_pycolmap_and_the_machine_have_one(monkeypatch):
    for cuda, found in ((True, "here"), (True, None), (False, "here")):
        monkeypatch.setattr(runs.pycolmap, "has_cuda", cuda)
        monkeypatch.setattr(runs.shutil, "which", lambda _, found=found: found)
        assert (runs.device().name == "auto") == bool(cuda and found)


def test_poses_are_found_from_images_alone(tmp_path):
    truth = poses(7)
    image_files.write(render(truth), tmp_path / "images", [f"{i}.png" for i in range(7)])
    flat = np.full((1, 180, 240, 3), 99, np.uint8)
    image_files.write(flat, tmp_path / "images", ["7.png"])
    found = read_folder(tmp_path, poses="colmap", long_side=64)
    assert found.dropped == {"7.png": "not placed by COLMAP"}
    assert found.capture.names == tuple(f"{i}.png" for i in range(7))
    assert aligned_error(found.capture.world_to_camera, truth) < 0.03
    assert found.agreement.kind == "reprojection"
    assert found.agreement.median < 1
    assert len(found.capture.points.xyz) > 100


def test_a_large_video_is_placed_at_the_size_of_its_features(tmp_path):
    truth, size = poses(6), (1280, 960)
    names = [f"{i}.png" for i in range(len(truth))]
    image_files.write([cv2.resize(image, size) for image in render(truth)], tmp_path, names)
    work = Work(tmp_path / "work", [Part(range(len(names)), ordered=True)])
    model = sfm.place(bare.of_files(names, [tmp_path / name for name in names]), work).model
    assert {image_files.size_of(file) for file in work.folder.glob("images/*")} == {(640, 480)}
    enlarge(model, lambda _: size)
    (camera,) = model.cameras.values()
    assert (camera.width, camera.height) == size
    assert camera.mean_focal_length() == pytest.approx(1200, rel=0.05)
    assert model.compute_mean_reprojection_error() < 2
    found = [model.find_image_with_name(name).cam_from_world().matrix() for name in names]
    assert aligned_error(found, truth) < 0.02


def test_images_without_poses_say_what_to_do(tmp_path):
    image_files.write(render(poses(3)), tmp_path, [f"{i}.jpg" for i in range(3)])
    with pytest.raises(ValueError, match=r"no poses. Hint: `poses=colmap` finds them"):
        read_capture(tmp_path)
    with pytest.raises(ValueError, match=r"images without poses.*`poses: colmap` finds them"):
        read_capture(tmp_path, "images")


def write_estimate(folder, truth, kept):
    """A COLMAP model as an estimator exports it: half the size, a camera an image, no rigs."""
    model = pycolmap.Reconstruction()
    for i in kept:
        half = {"width": 120, "height": 90, "params": [112.5, 112.5, 60.25, 45.25]}
        camera = pycolmap.Camera(model="PINHOLE", camera_id=i + 1, **half)
        model.add_camera_with_trivial_rig(camera)
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(truth[i, :, :3]), truth[i, :, 3])
        image = pycolmap.Image(image_id=i + 1, name=f"{i}.png", camera_id=i + 1)
        model.add_image_with_trivial_frame(image, rigid)
    write_model(model, folder, text=True)
    for name in ("rigs.txt", "frames.txt"):
        (folder / name).unlink()


def test_poses_of_another_estimator(tmp_path):
    truth = poses()
    write_posed(tmp_path, poses()[::-1])  # the layout's own poses are others
    shutil.rmtree(tmp_path / "images")
    image_files.write(render(truth), tmp_path / "images", [f"{i}.png" for i in range(10)])
    write_estimate(tmp_path / "vggt" / "sparse", truth, [0, 1, 2, 4, 6, 9])
    found = read_folder(tmp_path, poses="file", model="vggt/sparse", long_side=240)
    assert found.capture.names == ("0.png", "1.png", "2.png", "4.png", "6.png", "9.png")
    np.testing.assert_allclose(found.capture.world_to_camera, truth[[0, 1, 2, 4, 6, 9]], atol=1e-9)
    np.testing.assert_allclose(found.capture.intrinsics[0], [225, 225, 120.5, 90.5])
    assert set(found.dropped.values()) == {"not in vggt/sparse"}
    assert found.agreement.kind == "epipolar"
    assert found.agreement.median < 1


def test_a_model_of_other_images_is_refused(tmp_path):
    image_files.write(render(poses(3)), tmp_path / "images", ["a.png", "b.png", "c.png"])
    write_estimate(tmp_path / "vggt", poses(3), range(3))
    with pytest.raises(ValueError, match=r"none of the model's images \['0\.png'"):
        read_capture(tmp_path, poses="file", model="vggt")
    with pytest.raises(ValueError, match="`model` names no folder"):
        read_capture(tmp_path, poses="file")


def test_neighbours_are_near_and_look_alike():
    truth = poses(30)
    truth[15:] = np.array([np.diag([-1.0, 1, -1]) @ pose for pose in truth[15:]])
    pairs = neighbours(around(truth, size=(8, 6)))
    assert all((i < 15) == (j < 15) for i, j in pairs)
    assert (0, 1) in pairs
    assert (0, 14) not in pairs
