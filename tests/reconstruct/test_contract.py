"""What every reconstructor says of itself: its needs, and what a model cost."""

import mmap
import re
from dataclasses import replace

import numpy as np
import pytest
from coloured_wall import wall
from selection_problems import around, capture_of
from small_captures import ring

from fsel.core.limits import THREADS
from fsel.core.points import SparsePoints
from fsel.reconstruct import RECONSTRUCTORS, check_needs
from fsel.reconstruct.configured import Peak
from fsel.reconstruct.gaussians import render
from fsel.reconstruct.radiance_field import grid

# those that learn, with what is quick
LEARNING = [
    ("gaussians", {"steps": 60, "gaussians": 800}),
    ("gaussians", {"steps": 60, "gaussians": 800, "initial": "points"}),
    ("radiance_field", {"sides": (12, 20), "steps": (10, 10), "rays": 512}),
]
SHORT = {"steps": 102, "gaussians": 3000, "dropout": 0.1}
MEGABYTE = 1 << 20
OWN = ("splats", "gaussians", "radiance_field")  # those that need nothing else
QUICK = {
    "gaussians": {"steps": 2, "gaussians": 50},
    "radiance_field": {"sides": [8], "steps": [2], "rays": 64},
}


@pytest.mark.parametrize("name", OWN)
def test_a_setting_that_is_not_taken_is_refused_by_name_without_a_capture(name):
    check_needs({"name": name, "settings": QUICK.get(name, {"planes": [16, 32]})})
    with pytest.raises(ValueError, match=rf"reconstructor '{name}': no setting 'stepps'; allowed"):
        check_needs({"name": name, "settings": {"stepps": 3}})


class Needy:
    """Needs what no machine has."""

    @staticmethod
    def check(weights: str) -> None:
        raise FileNotFoundError(f"weights: no file {weights}. Hint: https://example.org has them")


def test_what_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(RECONSTRUCTORS, "needy", Needy)
    with pytest.raises(ValueError, match=r"reconstructor 'needy': weights: no file w.pt. Hint"):
        check_needs({"name": "needy", "settings": {"weights": "w.pt"}})
    monkeypatch.setitem(RECONSTRUCTORS.homes, "absent", "no_such_package:Absent")
    with pytest.raises(ValueError, match=r"reconstructor 'absent'.*needs no_such_package"):
        check_needs({"name": "absent", "settings": {}})


@pytest.mark.parametrize("name", OWN)
def test_a_model_says_what_it_cost_and_where(name):
    capture = around(ring(6), size=(24, 18))
    model = RECONSTRUCTORS[name](capture, **QUICK.get(name, {})).fit(np.arange(4))
    assert model.seconds > 0
    assert model.peak_bytes >= 0
    assert model.device == "cpu"
    assert (model.primitives == 0) == (model.bytes == 0)


def spoiled(case):
    """Six cameras on a circle that look at its middle, or at what is wrong with them."""
    poses = ring(6)
    rotations = poses[:, :, :3]
    centers = -np.einsum("nij,ni->nj", rotations, poses[:, :, 3])
    if case == "all in one place":
        centers = np.repeat(centers[:1], 6, axis=0)
    elif case == "no overlap":
        rotations = rotations * np.array([-1, 1, -1])[:, None]  # half a turn: they look outwards
    capture = capture_of(centers, rotations, size=(24, 18))
    if case == "a mask that hides everything":
        return replace(capture, masks=np.zeros(capture.images.shape[:3], bool))
    return capture


@pytest.mark.parametrize("case", ["all in one place", "no overlap", "a mask that hides everything"])
@pytest.mark.parametrize("name", OWN)
def test_frames_that_tell_nothing_give_a_model_that_renders_colours(name, case):
    capture = spoiled(case)
    model = RECONSTRUCTORS[name](capture, **QUICK.get(name, {})).fit(np.arange(6))
    for views in (capture.views, spoiled("none").views):
        rendered = model.render(views)
        assert rendered.shape == (6, 18, 24, 3)
        assert np.isfinite(rendered).all()
        assert rendered.min() >= 0
        assert rendered.max() <= 1


@pytest.mark.parametrize("frames", [[], [2], [2, 2], [1, 3, 1]])
@pytest.mark.parametrize("name", OWN)
def test_fewer_than_two_distinct_frames_are_refused_by_their_numbers(name, frames):
    bound = RECONSTRUCTORS[name](spoiled("none"), **QUICK.get(name, {}))
    with pytest.raises(ValueError, match=rf"distinct frames, got {re.escape(str(frames))}"):
        bound.fit(np.array(frames, np.int64))


@pytest.fixture(scope="module")
def walled():
    return wall()


def same(one, other, views):
    """Compare all that two models give."""
    np.testing.assert_array_equal(one.render(views), other.render(views))
    np.testing.assert_array_equal(one.frame.origin, other.frame.origin)
    assert (one.frame.unit, one.primitives) == (other.frame.unit, other.primitives)


@pytest.mark.parametrize(("name", "settings"), LEARNING)
def test_a_model_is_the_same_each_time_and_in_any_order_but_not_for_another_seed(
    walled, name, settings
):
    frames, bind = np.array([0, 2, 5, 7]), RECONSTRUCTORS[name]
    first, second = (bind(walled, **settings).fit(f) for f in (frames, frames[::-1]))
    same(first, second, walled.views)
    other = bind(walled, **settings, seed=1).fit(frames)
    assert (first.render(walled.views) != other.render(walled.views)).any()


@pytest.mark.parametrize(
    ("name", "settings", "least"),
    [
        ("splats", {}, 0),
        ("gaussians", SHORT, 2 * render.FEWEST),
        ("radiance_field", {"sides": (24, 30), "steps": (3, 5), "rays": 5000}, grid.FEWEST),
    ],
)
def test_any_number_of_threads_gives_the_same_bytes(name, settings, least, monkeypatch):
    large, made, losses = wall(size=(96, 72)), [], []
    masked = replace(large, masks=np.arange(96) > np.full((8, 72, 1), 20))
    for count in (1, 2, 3):
        monkeypatch.setenv(THREADS, str(count))
        given = [lambda *step: losses.append(step)] if name == "gaussians" else []
        model = RECONSTRUCTORS[name](masked, **settings).fit(np.arange(6), *given)
        parts = model.render(large.view([7])), *vars(getattr(model, "grid", model)).values()
        made.append([part.tobytes() for part in parts if isinstance(part, np.ndarray)])
    assert model.primitives > least
    assert made == made[:1] * 3
    assert len(set(losses)) == len(losses) / 3


@pytest.mark.parametrize(("name", "settings"), LEARNING)
def test_what_is_not_selected_changes_nothing(walled, name, settings):
    frames, rng = np.array([1, 3, 6]), np.random.default_rng(0)
    rest = np.setdiff1d(np.arange(8), frames)
    images, poses = walled.images.copy(), walled.world_to_camera.copy()
    ks = walled.intrinsics.copy()
    images[rest] = rng.integers(0, 256, images[rest].shape)
    poses[rest, :, 3] += rng.normal(0, 40, (len(rest), 3))
    ks[rest] *= 1.7
    points = walled.points
    chosen = np.isin(points.track_frame, frames)
    shared = np.bincount(points.track_point[chosen], minlength=len(points.xyz)) >= 2
    assert 5 < shared.sum() < len(points.xyz)
    xyz, rgb = points.xyz.copy(), points.rgb.copy()
    # some nearer than all others; tracks in other frames move too, and new points are seen there
    xyz[~shared], rgb[~shared] = rng.normal(0, 0.01, ((~shared).sum(), 3)), 255
    points = SparsePoints(
        np.concatenate([xyz, rng.normal(0, 9, (5, 3))]),
        np.concatenate([rgb, np.zeros((5, 3), np.uint8)]),
        np.concatenate([points.track_point, np.arange(5) + len(xyz)]),
        np.concatenate([np.where(chosen, points.track_frame, rest[0]), np.full(5, rest[1])]),
    )
    changed = replace(walled, images=images, world_to_camera=poses, intrinsics=ks, points=points)
    models = [RECONSTRUCTORS[name](c, **settings).fit(frames) for c in (walled, changed)]
    assert models[0].primitives > 10
    same(*models, walled.views)


@pytest.mark.parametrize(("name", "settings"), LEARNING[1:])
def test_nothing_outside_the_masks_is_learned(walled, name, settings):
    masks = np.zeros(walled.images.shape[:3], bool)
    masks[:, :, :20] = True
    spoilt = walled.images.copy()
    spoilt[~masks] = 255 - spoilt[~masks]
    captures = [replace(walled, images=images, masks=masks) for images in (walled.images, spoilt)]
    models = [RECONSTRUCTORS[name](c, **settings).fit(np.arange(8)) for c in captures]
    same(*models, walled.views)


@pytest.mark.parametrize(("name", "settings"), LEARNING)
def test_one_colour_everywhere_is_rendered(walled, name, settings):
    grey = replace(walled, images=np.full_like(walled.images, 77))
    model = RECONSTRUCTORS[name](grey, **settings).fit(np.arange(4))
    np.testing.assert_allclose(model.render(grey.view(np.array([2]))), 77 / 255, atol=0.02)


def touch(size):
    """Hold fresh pages, which no allocator has kept back, and give them up."""
    with mmap.mmap(-1, size) as pages:
        pages[:: mmap.PAGESIZE] = b"\1" * len(range(0, size, mmap.PAGESIZE))


def test_a_peak_is_what_was_held_at_once_and_survives_one_within():
    outer = Peak()
    touch(24 * MEGABYTE)
    inner = Peak()
    touch(8 * MEGABYTE)
    assert 7 * MEGABYTE < inner.bytes < 16 * MEGABYTE
    assert 23 * MEGABYTE < outer.bytes < 40 * MEGABYTE
