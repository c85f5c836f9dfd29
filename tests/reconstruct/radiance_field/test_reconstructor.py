"""The reconstructor: what it depends on, what it refuses, and that it learns."""

from dataclasses import replace

import numpy as np
import pytest

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints
from fsel.metrics import score_views
from fsel.reconstruct import RECONSTRUCTORS
from fsel.reconstruct.radiance_field import RadianceField

QUICK = {"sides": (12, 20), "steps": (10, 10), "rays": 512}
FOCAL = 30.0


def texture(x, y, phases):
    """(..., 3) smooth colours of a plane, 0 to 255."""
    waves = np.linspace(1.0, 3.5, len(phases))
    light = sum(
        np.sin(wave * (x * np.cos(n) + y * np.sin(n)))[..., None] * np.cos(phase)
        for n, (wave, phase) in enumerate(zip(waves, phases, strict=True))
    )
    return np.clip(128 + 45 * light, 0, 255)


def panel_before_a_wall(frames=10, size=(32, 24)):
    """Cameras in a row; a square panel at depth 2, a wall at depth 4, points on both."""
    rng = np.random.default_rng(0)
    phases = rng.uniform(0, 6, (2, 6, 3))
    width, height = size
    u = (np.arange(width) + 0.5 - width / 2) / FOCAL
    v = ((np.arange(height) + 0.5 - height / 2) / FOCAL)[:, None]
    poses, images = np.tile(np.eye(3, 4), (frames, 1, 1)), []
    for i, center in enumerate(np.linspace(-1, 1, frames)):
        poses[i, 0, 3] = -center
        near = center + 2 * u + 0 * v, 0 * u + 2 * v
        far = center + 4 * u + 0 * v, 0 * u + 4 * v
        panel = np.maximum(np.abs(near[0]), np.abs(near[1])) < 0.45
        images.append(
            np.where(panel[..., None], texture(*near, phases[0]), texture(*far, phases[1]))
        )
    xyz = np.concatenate(
        [
            np.column_stack([rng.uniform(-0.4, 0.4, (20, 2)), np.full(20, 2.0)]),
            np.column_stack([rng.uniform(-1, 1, (20, 2)), np.full(20, 4.0)]),
        ]
    )
    seen = np.argwhere((np.arange(40)[:, None] + np.arange(frames)) % 3 > 0)
    return Capture(
        names=tuple(f"{i}" for i in range(frames)),
        world_to_camera=poses,
        intrinsics=np.tile([FOCAL, FOCAL, width / 2, height / 2], (frames, 1)),
        images=np.array(images).astype(np.uint8),
        sequences=("a",) * frames,
        points=SparsePoints(xyz, np.zeros((40, 3), np.uint8), seen[:, 0], seen[:, 1]),
        source="panel",
    )


def psnr(model, capture, frames):
    return score_views(model.render(capture.view(frames)), capture.images[frames])[:, 0].mean()


def same(one, other):
    for part in ("occupied", "index", "density", "color"):
        np.testing.assert_array_equal(getattr(one.grid, part), getattr(other.grid, part))
    np.testing.assert_array_equal(one.background, other.background)
    np.testing.assert_array_equal(one.frame.origin, other.frame.origin)
    assert (one.frame.unit, one.near) == (other.frame.unit, other.near)


@pytest.fixture(scope="module")
def capture():
    return panel_before_a_wall()


def test_training_and_held_out_views_are_learned(capture):
    frames, held_out = np.array([0, 1, 2, 4, 5, 6, 8, 9]), np.array([3, 7])
    told = []
    bound = RECONSTRUCTORS["radiance_field"](capture, sides=(24, 48), steps=(60, 60), rays=1024)
    model = bound.fit(frames, lambda *step: told.append(step))
    assert [step[:2] for step in told] == [(i + 1, 120) for i in range(120)]
    assert told[-1][2] < told[0][2] / 10
    assert psnr(model, capture, frames) > 26
    assert psnr(model, capture, held_out) > 24
    splats = RECONSTRUCTORS["splats"](capture).fit(frames)
    assert psnr(model, capture, held_out) > psnr(splats, capture, held_out)
    assert 100 < model.primitives == model.grid.occupied.sum() < 47**3 / 4
    assert model.bytes >= 4 * 13 * len(model.grid.density)
    assert model.seconds > 0
    assert model.peak_bytes >= 0
    assert model.device == "cpu"


def test_the_model_is_the_same_each_time_and_in_any_order_but_not_for_another_seed(capture):
    frames = np.array([0, 2, 5, 7])
    first, second = (RadianceField(capture, **QUICK).fit(f) for f in (frames, frames[::-1]))
    same(first, second)
    other = RadianceField(capture, **QUICK, seed=1).fit(frames)
    image, another = (m.render(capture.view(frames)) for m in (first, other))
    assert (image != another).any()


def test_what_is_not_selected_changes_nothing(capture):
    frames = np.array([1, 3, 6])
    rest = np.setdiff1d(np.arange(10), frames)
    rng = np.random.default_rng(0)
    images, poses = capture.images.copy(), capture.world_to_camera.copy()
    ks = capture.intrinsics.copy()
    images[rest] = rng.integers(0, 256, images[rest].shape)
    poses[rest, :, 3] += rng.normal(0, 40, (len(rest), 3))
    ks[rest] *= 1.7
    points = capture.points
    chosen = np.isin(points.track_frame, frames)
    shared = np.bincount(points.track_point[chosen], minlength=len(points.xyz)) >= 2
    assert 5 < shared.sum() < len(points.xyz)
    xyz = points.xyz.copy()
    xyz[~shared] = rng.normal(0, 0.01, ((~shared).sum(), 3))  # nearer than all others
    points = replace(points, xyz=xyz, track_frame=np.where(chosen, points.track_frame, rest[0]))
    changed = replace(capture, images=images, world_to_camera=poses, intrinsics=ks, points=points)
    same(*(RadianceField(c, **QUICK).fit(frames) for c in (capture, changed)))


def test_a_shifted_and_scaled_world_gives_the_same_images(capture):
    frames, shift = np.array([0, 3, 6, 9]), np.array([4e5, -3e5, 5e5])
    poses = capture.world_to_camera.copy()
    poses[:, :, 3] = 100 * poses[:, :, 3] - poses[:, :, :3] @ shift
    points = replace(capture.points, xyz=100 * capture.points.xyz + shift)
    moved = replace(capture, world_to_camera=poses, points=points)
    images = [
        RadianceField(c, **QUICK).fit(frames).render(c.view(np.arange(10)))
        for c in (capture, moved)
    ]
    np.testing.assert_allclose(images[0], images[1], atol=2e-3)


def test_rays_start_before_the_nearest_points(capture):
    model = RadianceField(capture, **QUICK).fit(np.arange(10))
    assert model.near == 0.1  # the nearest points are at twice the cameras' distance
    close = replace(capture, points=replace(capture.points, xyz=0.06 * capture.points.xyz))
    assert RadianceField(close, **QUICK).fit(np.arange(10)).near == pytest.approx(0.06, rel=1e-6)
    bare = replace(capture, points=None)
    assert RadianceField(bare, **QUICK).fit(np.arange(10)).near == 0.1


def test_masked_pixels_are_not_read(capture):
    masks = np.zeros(capture.images.shape[:3], bool)
    masks[:, :, 8:] = True
    painted = capture.images.copy()
    painted[~masks] = 255 - painted[~masks]
    models = [
        RadianceField(replace(capture, images=images, masks=masks), **QUICK).fit(np.arange(4))
        for images in (capture.images, painted)
    ]
    same(*models)


def test_masks_that_hide_everything_leave_a_black_background(capture):
    hidden = replace(capture, masks=np.zeros(capture.images.shape[:3], bool))
    model = RadianceField(hidden, **QUICK).fit(np.arange(4))
    assert model.primitives == 0
    assert not model.render(capture.view(np.array([0]))).any()


def test_one_colour_everywhere_is_rendered(capture):
    grey = replace(capture, images=np.full_like(capture.images, 77))
    images = RadianceField(grey, **QUICK).fit(np.arange(4)).render(capture.view(np.array([5])))
    np.testing.assert_allclose(images, 77 / 255, atol=2e-3)


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
        ({"density_rate": 0}, "density_rate must be above zero"),
        ({"color_rate": float("nan")}, "color_rate must be above zero"),
        ({"density_variation": -1}, "density_variation must be zero or more"),
        ({"color_variation": "much"}, "color_variation must be zero or more"),
        ({"visible": 1}, "visible must be at least 0 and below 1"),
    ],
)
def test_settings_outside_their_range_are_refused_by_name(capture, settings, named):
    with pytest.raises(ValueError, match=named):
        RadianceField(capture, **settings)


def test_settings_may_come_from_a_config_file(capture):
    bound = RadianceField(capture, sides=[12, 20], steps=[3, 3], degree=0, density_variation=0)
    assert bound.settings.sides == (12, 20)
    assert bound.fit(np.arange(3)).primitives > 0
