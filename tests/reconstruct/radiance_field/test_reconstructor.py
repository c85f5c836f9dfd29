"""The reconstructor: what it depends on, what it refuses, and that it learns."""

from dataclasses import replace

import numpy as np
import pytest
from coloured_wall import in_another_world, psnr, wall

from fsel.reconstruct import RECONSTRUCTORS
from fsel.reconstruct.radiance_field import RadianceField

QUICK = {"sides": (12, 20), "steps": (10, 10), "rays": 512}


@pytest.fixture(scope="module")
def capture():
    return wall()


def test_training_and_held_out_views_are_learned(capture):
    frames, held_out = np.array([0, 1, 3, 4, 6, 7]), np.array([2, 5])
    bound = RECONSTRUCTORS["radiance_field"](capture, sides=(24, 48), steps=(60, 60), rays=1024)
    model = bound.fit(frames)
    assert psnr(model, capture, frames) > 30
    assert psnr(model, capture, held_out) > 30
    assert 100 < model.primitives == model.grid.occupied.sum() < 47**3 / 4
    assert model.bytes >= 4 * 13 * len(model.grid.density)


def test_a_shifted_and_scaled_world_gives_the_same_images(capture):
    frames = np.array([0, 3, 6, 7])
    moved = in_another_world(capture, 100, [4e5, -3e5, 5e5])
    images = [
        RadianceField(c, **QUICK).fit(frames).render(c.view(np.arange(8))) for c in (capture, moved)
    ]
    np.testing.assert_allclose(images[0], images[1], atol=2e-3)


def test_rays_start_before_the_nearest_points(capture):
    model = RadianceField(capture, **QUICK).fit(np.arange(8))
    assert model.near == 0.1  # the nearest points are farther
    close = replace(capture, points=replace(capture.points, xyz=0.06 * capture.points.xyz))
    assert RadianceField(close, **QUICK).fit(np.arange(8)).near == pytest.approx(
        0.06 * 2.4 / 2 / 0.875  # half of the way to the nearest, in units of the farthest camera
    )
    bare = replace(capture, points=None)
    assert RadianceField(bare, **QUICK).fit(np.arange(8)).near == 0.1


def test_masks_that_hide_everything_leave_a_black_background(capture):
    hidden = replace(capture, masks=np.zeros(capture.images.shape[:3], bool))
    model = RadianceField(hidden, **QUICK).fit(np.arange(4))
    assert model.primitives == 0
    assert not model.render(capture.view(np.array([0]))).any()


def test_views_of_another_size_are_rendered_at_theirs(capture):
    model = RadianceField(capture, **QUICK).fit(np.arange(4))
    views = replace(capture.view(np.array([1])), size=(9, 7))
    np.testing.assert_array_equal(
        model.render(views)[0], model.render(capture.view(np.array([1])))[0, :7, :9]
    )


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"sides": (40,)}, "sides and steps must state as many stages"),
        ({"sides": (), "steps": ()}, "sides and steps must state as many stages"),
        ({"sides": (48, 40, 80)}, "sides must rise"),
        ({"sides": (2, 40, 80)}, "each of sides must be an integer from 4 to 512"),
        ({"sides": (40, 80, 4096)}, "each of sides must be an integer from 4 to 512"),
        ({"sides": 40}, "sides must be a list of integers"),
        ({"steps": (10, 10.5, 10)}, "each of steps must be an integer from 1"),
        ({"steps": (10, 0, 10)}, "each of steps must be an integer from 1"),
        ({"rays": 0}, "rays must be an integer from 1"),
        ({"degree": 3}, "degree must be an integer from 0 to 2"),
        ({"degree": True}, "degree must be an integer"),
        ({"seed": -1}, "seed must be an integer from 0"),
    ],
)
def test_settings_outside_their_range_are_refused_by_name(capture, settings, named):
    with pytest.raises(ValueError, match=named):
        RadianceField(capture, **settings)
