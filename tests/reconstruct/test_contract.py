"""What every reconstructor says of itself: its needs, and what a model cost."""

import mmap
import re
from dataclasses import replace

import numpy as np
import pytest
from selection_problems import around, capture_of
from small_captures import ring

from fsel.reconstruct import RECONSTRUCTORS, check_needs
from fsel.reconstruct.configured import Peak

MEGABYTE = 1 << 20
OWN = ("splats", "gaussians", "radiance_field")  # those that need nothing else
QUICK = {
    "gaussians": {"steps": 2, "gaussians": 50},
    "radiance_field": {"sides": [8], "steps": [2], "rays": 64},
}


@pytest.mark.parametrize("name", OWN)
def test_a_setting_that_is_not_taken_is_refused_by_name_without_a_capture(name):
    check_needs({"name": name, "settings": {}})
    with pytest.raises(ValueError, match=rf"reconstructor '{name}': no setting 'stepps'; allowed"):
        check_needs({"name": name, "settings": {"stepps": 3}})


@pytest.mark.parametrize(
    ("name", "settings", "said"),
    [
        ("splats", {"partners": 9}, "partners must be 1 to 4, got 9"),
        ("gaussians", {"steps": -1}, "steps must be an integer from 0, got -1"),
    ],
)
def test_a_value_out_of_range_is_refused_without_a_capture(name, settings, said):
    with pytest.raises(ValueError, match=rf"reconstructor '{name}': {said}"):
        check_needs({"name": name, "settings": settings})


def test_a_list_of_a_config_is_as_good_as_a_tuple():
    check_needs({"name": "splats", "settings": {"planes": [16, 32]}})


class Needy:
    """Needs what no machine has."""

    @staticmethod
    def check(weights: str) -> None:
        raise FileNotFoundError(f"weights: no file {weights}. Hint: https://example.org has them")


def test_what_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(RECONSTRUCTORS, "needy", Needy)
    with pytest.raises(ValueError, match=r"reconstructor 'needy': weights: no file w.pt. Hint"):
        check_needs({"name": "needy", "settings": {"weights": "w.pt"}})
    RECONSTRUCTORS.homes["absent"] = "no_such_package:Absent"
    try:
        with pytest.raises(ValueError, match=r"reconstructor 'absent'.*needs no_such_package"):
            check_needs({"name": "absent", "settings": {}})
    finally:
        del RECONSTRUCTORS.homes["absent"]


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
    if case == "one colour":
        return replace(capture, images=np.full_like(capture.images, 90))
    return capture


@pytest.mark.parametrize(
    "case", ["all in one place", "no overlap", "a mask that hides everything", "one colour"]
)
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


def test_a_frame_of_another_size_makes_no_capture_that_could_be_reconstructed():
    capture = spoiled("none")
    images = np.empty(6, object)
    images[:] = [*capture.images[:5], capture.images[5][:9]]
    with pytest.raises(ValueError, match=r"images must be \(6, h, w, 3\) uint8, got \(6,\)"):
        replace(capture, images=images)
    with pytest.raises(ValueError, match="masks"):
        replace(capture, masks=np.ones((6, 9, 24), bool))


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
