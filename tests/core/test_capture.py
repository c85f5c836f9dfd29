"""The capture model refuses what it cannot stand for, and survives the disk."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints


def capture(n=5, seed=0):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(n, rng=rng).as_matrix()
    pose = np.concatenate([rotation, rng.normal(size=(n, 3, 1))], axis=2)
    return Capture(
        names=tuple(f"frame_{i}" for i in range(n)),
        world_to_camera=pose,
        intrinsics=np.tile([50.0, 60.0, 32.0, 24.0], (n, 1)),
        images=rng.integers(0, 255, (n, 48, 64, 3), dtype=np.uint8),
        sequences=("a",) * n,
        points=SparsePoints(
            rng.normal(size=(3, 3)),
            rng.integers(0, 255, (3, 3), dtype=np.uint8),
            np.array([0, 0, 1, 2, 2, 2]),
            np.array([0, 1, 2, 0, 3, 4]),
        ),
        source="a test",
    )


def test_centre_and_axis_by_hand():
    quarter = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    pose = np.concatenate([quarter, (-quarter @ [1.0, 2.0, 3.0])[:, None]], axis=1)
    one = replace(capture(1), world_to_camera=pose[None])
    np.testing.assert_allclose(one.centers[0], [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(one.axes[0], [-1, 0, 0], atol=1e-12)


def test_saved_and_loaded_is_the_same(tmp_path):
    first = replace(capture(), masks=capture().images[..., 0] > 99)
    first.save(tmp_path)
    again = Capture.load(tmp_path)
    assert (again.names, again.source) == (first.names, "a test")
    for field in ("world_to_camera", "intrinsics", "images", "masks"):
        np.testing.assert_array_equal(getattr(again, field), getattr(first, field))
    for field in ("xyz", "rgb", "track_point", "track_frame"):
        np.testing.assert_array_equal(getattr(again.points, field), getattr(first.points, field))
    replace(first, masks=None, points=None).save(tmp_path)  # nothing of the former stays
    bare = Capture.load(tmp_path)
    assert (bare.masks, bare.points) == (None, None)
    (tmp_path / "masks.npy").unlink()  # as folders of earlier versions lack it
    assert Capture.load(tmp_path).masks is None


def test_a_subset_has_its_frames_in_order_and_what_they_observe():
    first = capture()
    masks = np.arange(first.images[..., 0].size).reshape(first.images.shape[:3]) % 3 == 0
    part = replace(first, masks=masks).subset(np.array([3, 0]))
    assert part.names == (first.names[3], first.names[0])
    assert first.subset(np.array([3, 0]), part.images).images is part.images
    for field in ("world_to_camera", "intrinsics", "images"):
        np.testing.assert_array_equal(getattr(part, field), getattr(first, field)[[3, 0]])
    np.testing.assert_array_equal(part.masks, masks[[3, 0]])
    # point 0 is seen by the old frame 0, point 2 by the old frames 0 and 3; all points stay
    assert part.points.track_point.tolist() == [0, 2, 2]
    assert part.points.track_frame.tolist() == [1, 1, 0]
    np.testing.assert_array_equal(part.points.xyz, first.points.xyz)
    np.testing.assert_array_equal(part.views.centers, first.views.subset([3, 0]).centers)


def test_views_are_joined_in_order():
    given = capture()
    both, wanted = given.view([2, 0]).joined(given.view([1])), given.view([2, 0, 1])
    np.testing.assert_array_equal(both.world_to_camera, wanted.world_to_camera)
    assert (both.intrinsics.shape, both.size) == ((3, 4), given.size)


def test_resizing_keeps_the_field_of_view_and_the_mean():
    first = capture()
    small = first.resized(32)
    assert small.size == (32, 24)
    np.testing.assert_allclose(small.intrinsics[0], [25, 30, 16, 12])
    np.testing.assert_allclose(small.views.half_fov, first.views.half_fov)
    assert abs(small.images.mean() - first.images.mean()) < 0.5
    assert first.resized(64) is first


def poison(poses):
    poses[1, 0, 3] = -np.inf
    return poses


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("world_to_camera", lambda p: p * [[-1], [1], [1]], "frame_0.*determinant -1"),
        ("world_to_camera", poison, "frame_1.*not finite"),
        ("world_to_camera", lambda p: p * 1.1, "frame_0.*orthonormal"),
        ("world_to_camera", lambda p: p[:3], "world_to_camera must be"),
        ("intrinsics", lambda k: k * -1, "positive focal"),
        ("names", lambda n: ("x",) * len(n), "distinct"),
        ("images", lambda i: i.astype(float), "uint8"),
        ("sequences", lambda s: s[:2], "sequences must name 5"),
    ],
)
def test_bad_values_are_refused_by_name(field, change, message):
    good = capture()
    with pytest.raises(ValueError, match=message):
        replace(good, **{field: change(getattr(good, field))})
