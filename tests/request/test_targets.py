"""Requests become views: every form, in the capture's world, about an object or not."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from selection_problems import capture_of
from small_captures import ring

from fsel.capture import Views
from fsel.export import service
from fsel.export.service import service_of
from fsel.features.static import proxy_points
from fsel.geometry import directions
from fsel.problem import Problem
from fsel.request import focus, paths
from fsel.request.problem import request_problem
from fsel.request.targets import sees, targets_of


def around(poses, **more):
    """A capture with the given world-to-camera poses."""
    rotations = poses[:, :, :3]
    centers = -np.einsum("nij,ni->nj", rotations, poses[:, :, 3])
    return capture_of(centers, rotations, size=(64, 48), **more)


@pytest.fixture
def circle():
    return around(ring(24))


def is_rotation(views):
    rotation = views.world_to_camera[:, :, :3]
    product = rotation @ np.swapaxes(rotation, 1, 2)
    return np.allclose(product, np.eye(3)) and np.allclose(np.linalg.det(rotation), 1)


def test_an_orbit_keeps_the_cameras_distance_and_height_and_looks_at_their_point(circle):
    views = paths.orbit(circle, 12)
    np.testing.assert_allclose(np.hypot(views.centers[:, 0], views.centers[:, 2]), 4)
    np.testing.assert_allclose(views.centers[:, 1], -1)
    np.testing.assert_allclose(views.axes, directions(np.zeros(3), views.centers), atol=1e-9)
    turn = np.unwrap(np.arctan2(views.centers[:, 2], views.centers[:, 0]))
    np.testing.assert_allclose(np.abs(np.diff(turn)), np.pi / 6)
    assert is_rotation(views)
    np.testing.assert_allclose(views.world_to_camera[:, 1, 1] > 0, True)  # upright: y is down


def test_an_orbit_leaves_out_what_no_camera_filmed():
    half = around(ring(24)[:13])
    views = paths.orbit(half, 12)
    ends = half.centers[[0, 12]]
    gap = np.linalg.norm(views.centers[[0, -1], None] - ends, axis=2)
    np.testing.assert_allclose(gap.min(axis=1), 0, atol=1e-9)
    assert (views.centers[:, 2] > -1e-9).all()


def test_up_is_upright_on_a_straight_track_and_on_one_side_of_an_object():
    side = around(ring(24)[:5])
    np.testing.assert_allclose(paths.upwards(side), [0, -1, 0], atol=1e-9)
    tilt = cv2.Rodrigues(np.array([0.2, 0, 0]))[0]  # all look down alike: level is not known
    track = capture_of(np.arange(15.0).reshape(5, 3), np.tile(tilt, (5, 1, 1)))
    np.testing.assert_allclose(paths.upwards(track), -tilt[1], atol=1e-9)


def test_cameras_without_a_common_point_have_no_orbit():
    same = np.tile(np.eye(3), (5, 1, 1))
    with pytest.raises(ValueError, match="parallel lines"):
        targets_of(capture_of(np.arange(15.0).reshape(5, 3), same), "orbit")
    named = replace(capture_of(np.arange(15.0).reshape(5, 3), same), source="a folder")
    with pytest.raises(ValueError, match=r"^a folder: the cameras look along"):
        targets_of(named, "orbit")
    outward = ring(24)
    turned = np.diag([-1.0, 1, -1]) @ outward  # each about its own upright axis
    with pytest.raises(ValueError, match="use `trajectory`"):
        targets_of(around(turned), "orbit")


def test_a_trajectory_is_the_smoothed_path_of_each_pass(circle):
    views = paths.trajectory(circle, 50)
    radius = np.hypot(views.centers[:, 0], views.centers[:, 2])
    assert (np.abs(radius - 4) < 0.4).all()
    assert is_rotation(views)
    centers = np.zeros((20, 3))
    centers[:, 0] = np.arange(20)
    centers[10:, 1] = 100
    apart = capture_of(centers, np.tile(np.eye(3), (20, 1, 1)), sequences=("a",) * 10 + ("b",) * 10)
    heights = paths.trajectory(apart, 40).centers[:, 1]
    assert np.isclose(heights, 0).sum() == np.isclose(heights, 100).sum() == 20


def test_views_for_the_whole_capture_lie_among_the_cameras(circle):
    targets = targets_of(circle, None)
    assert targets.kind == "the whole capture"
    assert len(targets.views) == 24
    assert len(targets.frames) == 0
    assert is_rotation(targets.views)
    radius = np.hypot(targets.views.centers[:, 0], targets.views.centers[:, 2])
    assert ((radius > 3.4) & (radius <= 4 + 1e-9)).all()


def test_views_beside_others_are_shifted_and_turned_by_the_stated_spread(circle):
    views = circle.view(np.arange(24).repeat(40))
    both = paths.with_views_beside(views, circle)
    np.testing.assert_array_equal(both.world_to_camera[: len(views)], views.world_to_camera)
    off = both.subset(slice(len(views), None))
    assert is_rotation(off)
    shift = (off.centers - views.centers) / 4  # the circle's radius is its reach
    np.testing.assert_allclose(shift.std(axis=0), 0.2, rtol=0.1)
    turned = off.world_to_camera[:, :, :3] @ np.swapaxes(views.world_to_camera[:, :, :3], 1, 2)
    about = np.array([cv2.Rodrigues(turn)[0].ravel() for turn in turned])
    np.testing.assert_allclose(np.degrees(about.std(axis=0)), 12, rtol=0.1)


def test_views_beside_others_follow_the_world(circle):
    turn = cv2.Rodrigues(np.array([0.3, -0.2, 0.9]))[0]
    rotations = circle.world_to_camera[:, :, :3] @ turn.T
    moved = capture_of(3 * circle.centers @ turn.T + 7, rotations, size=(64, 48))
    here, there = (paths.with_views_beside(c.view(np.arange(9)), c) for c in (circle, moved))
    np.testing.assert_allclose(there.centers, 3 * here.centers @ turn.T + 7, atol=1e-9)
    np.testing.assert_allclose(there.axes, here.axes @ turn.T, atol=1e-12)


def test_views_off_the_path_are_served_where_nothing_is_asked_for(circle):
    about = focus.Focus(np.zeros(3), np.zeros((1, 3)), "a point")
    problems = {
        (asked, thing): request_problem(
            circle, targets_of(circle, asked), np.zeros(24), about if thing else None, None
        )
        for asked, thing in ((None, False), (None, True), ("every:8", False))
    }
    assert [len(p.targets) for p in problems.values()] == [48, 24, 3]
    assert [p.whole for p in problems.values()] == [True, True, False]
    assert all(len(p.proxies) == len(p.targets) for p in problems.values())


def test_a_camera_path_is_read_back_in_the_captures_world(circle, tmp_path):
    asked = ring(5)
    rotation = cv2.Rodrigues(np.array([0.3, -0.2, 0.9]))[0]
    transform = np.vstack([np.column_stack([rotation, [1.0, 2, 3]]), [0, 0, 0, 1]])
    stated = []
    for pose in asked:
        matrix = np.linalg.inv(np.vstack([pose, [0, 0, 0, 1]])) @ np.diag([1.0, -1, -1, 1])
        moved = transform @ matrix
        moved[:3, 3] *= 0.25
        stated.append({"camera_to_world": moved.ravel().tolist()})
    (tmp_path / "path.json").write_text(json.dumps({"camera_path": stated}))
    beside = {"transform": transform[:3].tolist(), "scale": 0.25}
    (tmp_path / "dataparser_transforms.json").write_text(json.dumps(beside))
    views = targets_of(circle, tmp_path / "path.json").views
    np.testing.assert_allclose(views.world_to_camera, asked, atol=1e-9)


def test_the_applied_transform_of_a_transforms_file_is_undone(circle, tmp_path):
    applied = np.array([[0.0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]])
    frames = []
    for pose in ring(5):
        matrix = np.linalg.inv(np.vstack([pose, [0, 0, 0, 1]])) @ np.diag([1.0, -1, -1, 1])
        full = np.vstack([applied, [0, 0, 0, 1]]) @ matrix
        frames.append({"transform_matrix": full.tolist()})
    content = {"applied_transform": applied.tolist(), "frames": frames}
    (tmp_path / "p.json").write_text(json.dumps(content))
    views = targets_of(circle, tmp_path / "p.json").views
    np.testing.assert_allclose(views.world_to_camera, ring(5), atol=1e-9)


def test_a_long_path_is_thinned_evenly_with_both_ends(circle):
    poses = ring(200)
    targets = targets_of(circle, Views(poses, np.tile(circle.intrinsics[0], (200, 1)), (64, 48)))
    assert len(targets.views) == 60
    np.testing.assert_array_equal(targets.views.world_to_camera[[0, -1]], poses[[0, -1]])


def test_frames_are_held_out_by_name_and_by_number(circle):
    for request in (["frame_0005", "frame_0002"], [5, 2], np.array([2, 5, 5])):
        targets = targets_of(circle, request)
        np.testing.assert_array_equal(targets.frames, [2, 5])
        np.testing.assert_array_equal(targets.views.world_to_camera, circle.world_to_camera[[2, 5]])
        np.testing.assert_array_equal(
            targets.pool(circle), [0, 1, 3, 4, *range(6, 24)], strict=False
        )


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ([], "no frame"),
        ([24], "24"),
        ([-1], "-1"),
        (["x.jpg"], "'x.jpg'; its names are like 'frame_0000'"),
        (list(range(23)), "at least two must remain"),
        ("spiral", "allowed: every:N, orbit"),
        ("every:x", "allowed: every:N"),
        ("every:2.5", "targets are 'every:2.5'; allowed: every:N.* a whole number from 2"),
    ],
)
def test_requests_without_sense_are_refused(request_, said, circle):
    with pytest.raises(ValueError, match=said):
        targets_of(circle, request_)


def test_a_wish_that_cannot_be_met_is_refused_for_its_own_reason(circle):
    targets = replace(targets_of(circle, [3]), blind=np.array([5]))
    for frame, never, why in (
        (3, None, "is held out as a target"),
        (5, None, "sees nothing of the object"),
        (7, [7], "is never to be selected"),
    ):
        said = f"frame 'frame_000{frame}' is to be selected always, and {why}$"
        with pytest.raises(ValueError, match=said):
            targets.wished(circle, [frame, 1], never)


TURNED = np.eye(4).tolist()


@pytest.mark.parametrize(
    ("key", "poses", "said"),
    [
        ("frames", [np.eye(4)[:3].tolist()] * 3 + [np.eye(4)[:, :3].tolist()], "must be 4x4"),
        ("camera_path", [TURNED, np.zeros((4, 4)).tolist()], r"'camera_path\[1\]': rotation has"),
        ("camera_path", [TURNED, [[1e400] * 4] * 4], r"camera_path\[1\] must be finite"),
        ("frames", [None], "field 'transform_matrix' is missing"),
    ],
)
def test_poses_of_a_path_are_rigid_motions(key, poses, said, circle, tmp_path):
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
        ({"scale": "x"}, "scale must be one number"),
        ({"transform": None}, "field 'transform' is missing"),
        ({"transform": [[0] * 4] * 3}, "transform cannot be undone"),
    ],
)
def test_a_damaged_transform_beside_a_path_is_named(change, said, circle, tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"camera_path": [{"camera_to_world": TURNED}]}))
    stated = {"scale": 1.0, "transform": TURNED[:3]} | change
    (tmp_path / "dataparser_transforms.json").write_text(json.dumps(stated))
    with pytest.raises(ValueError, match=rf"dataparser_transforms\.json: {said}"):
        targets_of(circle, tmp_path / "p.json")


@pytest.mark.parametrize("content", [{}, {"camera_path": [{"camera_to_world": [1, 2]}]}])
def test_a_path_of_another_kind_is_refused(content, circle, tmp_path):
    (tmp_path / "p.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=r"p\.json: (expected|camera_to_world of)"):
        targets_of(circle, tmp_path / "p.json")


def test_views_of_another_world_are_told(circle):
    poses = ring(4)
    poses[3, :, 3] += [0, 0, 50]
    intrinsics = np.tile(circle.intrinsics[0], (4, 1))
    targets = targets_of(circle, Views(poses, intrinsics, (64, 48)))
    np.testing.assert_array_equal(targets.far, [False, False, False, True])
    with pytest.raises(ValueError, match="another world frame"):
        targets_of(circle, Views(poses[3:], intrinsics[3:], (64, 48)))


@pytest.mark.parametrize("request_", [None, "trajectory", f"every:{10**30}"])
def test_cameras_in_one_place_are_near_one_another(request_):
    turns = [cv2.Rodrigues(np.array([0, turn, 0]))[0] for turn in np.linspace(0, 3, 12)]
    capture = capture_of(np.tile([0.1, 0.2, 0.3], (12, 1)), np.array(turns))
    assert not targets_of(capture, request_).far.any()


def test_a_view_sees_what_lies_in_front_of_it_and_in_its_image():
    views = Views(np.eye(4)[None, :3], np.array([[60.0, 60, 32, 24]]), (64, 48))
    corner = [32 / 60, 24 / 60, 1]
    points = np.array([[0.0, 0, 1], [0, 0, -1], corner, [0.54, 0, 1], [0, 0.41, 1]])
    np.testing.assert_array_equal(sees(views, points), [[True, False, True, False, False]])


def write_masks(folder, capture, point, ending=".png", wrong=()):
    """A disc where a point is seen, in the corner for the frames in `wrong`."""
    folder.mkdir()
    for i, name in enumerate(capture.names):
        local = capture.world_to_camera[i, :, :3] @ point + capture.world_to_camera[i, :, 3]
        fx, fy, cx, cy = capture.intrinsics[i]
        at = np.array([fx * local[0] / local[2] + cx, fy * local[1] / local[2] + cy]) - 0.5
        at = np.array([3.0, 3.0]) if i in wrong else at
        mask = np.zeros((192, 256), np.uint8)  # larger than the capture's images
        cv2.circle(mask, tuple(np.round(4 * at + 1.5).astype(int).tolist()), 8, 255, -1)
        cv2.imwrite(str(folder / f"{name}{ending}"), mask)


@pytest.mark.parametrize("ending", [".png", ".jpg.png"])
@pytest.mark.parametrize("wrong", [(), (3, 9)])
def test_masks_say_where_the_object_is(ending, wrong, circle, tmp_path):
    point = np.array([0.4, -0.2, 0.3])
    if ending == ".jpg.png":
        circle = type(circle)(
            **{**vars(circle), "names": tuple(f"{name}.jpg" for name in circle.names)}
        )
    write_masks(tmp_path / "m", circle, point, ending.removeprefix(".jpg"), wrong)
    found = focus.from_masks(circle, tmp_path / "m")
    np.testing.assert_allclose(found.center, point, atol=0.03)


def test_masks_that_show_nothing_are_refused(circle, tmp_path):
    with pytest.raises(FileNotFoundError, match="no such folder of masks"):
        focus.from_masks(circle, tmp_path / "m")
    (tmp_path / "m").mkdir()
    cv2.imwrite(str(tmp_path / "m" / "frame_0001.png"), np.zeros((48, 64), np.uint8))
    with pytest.raises(ValueError, match="the object is in 0 masks"):
        focus.from_masks(circle, tmp_path / "m")
    photo = np.zeros((48, 64, 3), np.uint8)
    photo[:, :, 2] = np.arange(64) * 4
    cv2.imwrite(str(tmp_path / "m" / "frame_0002.png"), photo)
    with pytest.raises(ValueError, match=r"frame_0002\.png: is in colour and no mask"):
        focus.from_masks(circle, tmp_path / "m")
    photo[:, :, 2] = 32
    cv2.imwrite(str(tmp_path / "m" / "frame_0002.png"), photo)  # a tint, as of JPEG
    with pytest.raises(ValueError, match="the object is in 0 masks"):
        focus.from_masks(circle, tmp_path / "m")


def test_a_box_has_a_centre_and_corners():
    found = focus.from_box(np.array([0.0, 0, 0, 2, 4, 6]))
    np.testing.assert_array_equal(found.center, [1, 2, 3])
    assert {tuple(corner) for corner in found.corners} == {
        (1, 2, 3),
        *((x, y, z) for x in (0, 2) for y in (0, 4) for z in (0, 6)),
    }
    for wrong in ([1, 2, 3], [1, 1, 1, 1, 1, 1], [0, 0, 0, 1, 1, np.nan], [0, 0, 0, 1, -1, 1]):
        with pytest.raises(ValueError, match=r"box is .*; allowed: x y z of its least corner"):
            focus.from_box(np.array(wrong, float))


def test_targets_that_miss_the_object_are_left_out(circle):
    away = ring(24)
    away[12:] = np.diag([-1.0, 1, -1]) @ away[12:]
    mixed = around(away)
    targets = targets_of(mixed, list(range(0, 24, 3)))
    box = focus.from_box(np.array([-0.1, -0.1, -0.1, 0.1, 0.1, 0.1]))
    kept = targets.seeing(box.corners, circle)
    np.testing.assert_allclose(kept.views.world_to_camera, away[[0, 3, 6, 9]], atol=1e-12)
    np.testing.assert_array_equal(kept.frames, targets.frames)  # still never selected
    with pytest.raises(ValueError, match="none of 8 target views"):
        targets.seeing(np.array([[0.0, 100, 0]]), circle)


def test_an_object_is_every_views_reference_point(circle):
    center = np.array([0.3, 0.1, -0.2])
    problem = Problem(
        circle, np.arange(24), np.arange(4), circle.views, np.zeros((24, 0)), np.ones(24), center
    )
    np.testing.assert_array_equal(proxy_points(problem, circle.view(np.arange(4))), [center] * 4)


def test_service_by_hand():
    """Frames at 0, 1, 2, 10 on a line, all looking alike, and a view at 0."""
    centers = np.zeros((4, 3))
    centers[:, 0] = [0, 1, 2, 10]
    line = capture_of(centers, np.tile(np.eye(3), (4, 1, 1)))
    close = np.array([1, 0.7, 0.49, 0.343])  # by rank
    whole = close @ [1, 1 / 2, 1 / 4, 1 / 8]
    result = service_of(line, line.view(np.array([0])), np.arange(4), np.array([2, 0]))
    expected = np.array([close[2], close[0] + close[2] / 2]) / whole
    np.testing.assert_allclose(result.curve, expected)
    np.testing.assert_allclose(result.gain, [expected[0], expected[1] - expected[0]])
    third = [close[0] + close[1] / 2 + close[2] / 4, close[0] + close[2] / 2 + close[3] / 4]
    np.testing.assert_allclose(
        result.left, [0, third[0] / whole - expected[1], 0, *([third[1] / whole - expected[1]])]
    )


def test_service_rises_to_one_and_each_frame_adds_less(circle):
    views = circle.view(np.array([1, 9, 17]))
    pool = np.setdiff1d(np.arange(24), [1, 9, 17])
    picks = np.array([2, 10, 18, *np.setdiff1d(pool, [2, 10, 18])])
    result = service_of(circle, views, pool, picks)
    np.testing.assert_array_equal(result.nearest_view[:3], [0, 1, 2])
    assert result.curve[-1] == pytest.approx(1)
    assert (result.gain >= -1e-12).all()
    first, second = (service_of(circle, views, pool, picks[:k]) for k in (1, 2))
    rows = np.searchsorted(pool, picks[:2])
    assert first.left[rows[1]] == pytest.approx(second.gain[1])
    assert (second.left <= first.left + 1e-12).all()


def test_service_is_the_same_in_blocks(circle, monkeypatch):
    views, pool, picks = circle.view(np.array([1, 9, 17])), np.arange(24), np.array([2, 10, 18])
    whole = service_of(circle, views, pool, picks)
    monkeypatch.setattr(service, "BLOCK", 7)
    np.testing.assert_array_equal(service_of(circle, views, pool, picks).left, whole.left)
