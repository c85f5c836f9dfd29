"""Where an object is, by masks or a box, and which views see it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from selection_problems import around
from small_captures import ring

from fsel.core.capture import Views
from fsel.selection import focus
from fsel.selection.targets import sees, targets_of


def test_a_view_sees_what_lies_in_front_of_it_and_in_its_image():
    views = Views(np.eye(4)[None, :3], np.array([[60.0, 60, 32, 24]]), (64, 48))
    corner = [32 / 60, 24 / 60, 1]
    points = np.array([[0.0, 0, 1], [0, 0, -1], corner, [0.54, 0, 1], [0, 0.41, 1]])
    np.testing.assert_array_equal(sees(views, points), [[True, False, True, False, False]])


def write_masks(folder, capture, point, wrong):
    """A disc where a point is seen, in the corner for the frames in `wrong`."""
    folder.mkdir()
    for i, name in enumerate(capture.names):
        local = capture.world_to_camera[i, :, :3] @ point + capture.world_to_camera[i, :, 3]
        fx, fy, cx, cy = capture.intrinsics[i]
        at = np.array([fx * local[0] / local[2] + cx, fy * local[1] / local[2] + cy]) - 0.5
        at = np.array([3.0, 3.0]) if i in wrong else at
        mask = np.zeros((192, 256), np.uint8)  # larger than the capture's images
        cv2.circle(mask, tuple(np.round(4 * at + 1.5).astype(int).tolist()), 8, 255, -1)
        cv2.imwrite(str(folder / f"{name}.png"), mask)


@pytest.mark.parametrize("ending", ["", ".jpg"])
@pytest.mark.parametrize("wrong", [(), (3, 9)])
def test_masks_say_where_the_object_is(ending, wrong, circle, tmp_path):
    point = np.array([0.4, -0.2, 0.3])
    circle = replace(circle, names=tuple(f"{name}{ending}" for name in circle.names))
    write_masks(tmp_path / "m", circle, point, wrong)
    thing = focus.from_masks(circle, tmp_path / "m")
    np.testing.assert_allclose(thing.center, point, atol=0.03)


@pytest.mark.parametrize(
    ("blue", "said"),
    [
        (0, "the object is in 0 masks"),
        (32, "the object is in 0 masks"),  # a tint, as of JPEG
        (np.arange(64) * 4, r"frame_0002\.png: is a colour image, not a mask"),
    ],
)
def test_masks_that_show_nothing_are_refused(blue, said, circle, tmp_path):
    (tmp_path / "m").mkdir()
    photo = np.zeros((48, 64, 3), np.uint8)
    photo[:, :, 2] = blue
    cv2.imwrite(str(tmp_path / "m" / "frame_0002.png"), photo)
    with pytest.raises(ValueError, match=said):
        focus.from_masks(circle, tmp_path / "m")


def test_a_box_has_a_centre_and_corners():
    thing = focus.from_box(np.array([0.0, 0, 0, 2, 4, 6]))
    np.testing.assert_array_equal(thing.center, [1, 2, 3])
    assert {tuple(corner) for corner in thing.corners} == {
        (1, 2, 3),
        *((x, y, z) for x in (0, 2) for y in (0, 4) for z in (0, 6)),
    }
    for wrong in ([1, 2, 3], [1, 1, 1, 1, 1, 1], [0, 0, 0, 1, 1, np.nan], [0, 0, 0, 1, -1, 1]):
        with pytest.raises(ValueError, match=r"box is .*; allowed: x y z of its minimum corner"):
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
