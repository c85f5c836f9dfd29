"""Points that transforms.json names, in the world of its poses."""

import numpy as np
import pytest
from plyfile import PlyData, PlyElement
from small_captures import pose_anew, ring, write_ring

import fsel
from fsel.captures.layouts.nerfstudio import NEW_APPLIED_TRANSFORM
from fsel.captures.read import read_capture

SCALE = 0.5
XYZ = np.array([[0.5, 0.25, -0.5], [0, 0, 0], [0, -90, 0]])  # the last above all cameras


@pytest.fixture
def capture(tmp_path):
    """A ring of cameras as nerfstudio exports it: turned, scaled, and without a COLMAP model."""
    folder = tmp_path / "capture"
    write_ring(folder)
    poses = []
    for pose in ring(24):
        turned = pose[:, :3] @ NEW_APPLIED_TRANSFORM[:, :3].T
        poses.append(np.column_stack([turned, SCALE * pose[:, 3]]))
    applied = {"applied_transform": NEW_APPLIED_TRANSFORM.tolist(), "applied_scale": SCALE}
    pose_anew(folder, poses, fl_y=61, ply_file_path="cloud.ply", **applied)
    write(folder / "cloud.ply", XYZ @ NEW_APPLIED_TRANSFORM[:, :3].T * SCALE)
    return folder


def write(path, xyz, kind="u1", colour=(10, 20, 30)):
    names = [*((axis, "<f8") for axis in "xyz"), *((c, kind) for c in ("red", "green", "blue"))]
    rows = np.array([(*place, *colour) for place in xyz], names)
    PlyData([PlyElement.describe(rows, "vertex")], byte_order="<").write(str(path))


def test_points_are_brought_to_the_world_of_the_poses(capture):
    found = read_capture(capture)
    np.testing.assert_allclose(found.world_to_camera, ring(24), atol=1e-12)
    np.testing.assert_allclose(found.points.xyz, XYZ, atol=1e-12)
    np.testing.assert_array_equal(found.points.rgb, [[10, 20, 30]] * 3)
    assert not len(found.points.track_point)


def test_a_selection_has_the_points_that_two_picks_hold(capture, tmp_path):
    out = tmp_path / "out"
    fsel.select(capture, 6, patience=0).export(out)
    again = read_capture(out)
    np.testing.assert_allclose(again.points.xyz, XYZ[:2], atol=1e-6)
    assert len(PlyData.read(str(out / "sparse_pc.ply"))["vertex"]) == 2


def test_colours_may_be_missing_or_shares(capture):
    for shares in ((0, 0.5, 1), (np.nan, 0.5, np.inf), (-1e38, 0.5, 3e38)):
        write(capture / "cloud.ply", XYZ, "<f4", shares)
        np.testing.assert_array_equal(read_capture(capture).points.rgb[0], [0, 128, 255])
    rows = np.array([tuple(place) for place in XYZ], [(axis, "<f4") for axis in "xyz"])
    PlyData([PlyElement.describe(rows, "vertex")]).write(str(capture / "cloud.ply"))
    np.testing.assert_array_equal(read_capture(capture).points.rgb[0], [128, 128, 128])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "cloud.ply: file of points is missing"),
        (b"ply\nformat ascii 1.0\nend_header\n", "cloud.ply: no .ply file of points"),
        (b"nothing of the kind", "cloud.ply: no .ply file of points"),
    ],
)
def test_what_is_no_cloud_is_refused(content, said, capture):
    (capture / "cloud.ply").unlink()
    if content is not None:
        (capture / "cloud.ply").write_bytes(content)
    with pytest.raises(ValueError, match=said):
        read_capture(capture)


def test_points_that_are_not_finite_are_refused(capture):
    write(capture / "cloud.ply", [[0, 0, 0], [0, np.inf, 0]])
    with pytest.raises(ValueError, match=r"cloud.ply: point 1 lies at .*not finite"):
        read_capture(capture)
