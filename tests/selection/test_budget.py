"""The number of frames: losses and memory by hand, and what `-k auto` keeps."""

import numpy as np
import pytest
from small_captures import write_ring

import fsel
from fsel.selection.budget import NEEDS, Auto, HowMany, enough, find, losses, shipped, within

SPLAT = 32  # bytes
RECORD = {
    "frames": [4, 16, 25],
    "low": [-1.0, -1.0, -1.0],
    "median": [2.0, 1.0, 0.0],
    "high": [5.0, 3.0, 2.0],
    "bound": [4.0, 1.0, 0.5],
    "better": [0.1, 0.2, 0.5],
    "total": [20, 400],
    "wide": [1.5],
}


def test_losses_between_the_numbers_that_were_measured():
    """1/sqrt(K) is 1/2, 1/4 and 1/5 at those, and 1/3 at K = 9."""
    lost = losses(RECORD, np.array([2, 4, 9, 16, 25, 99]))
    np.testing.assert_allclose(lost[0], -1)
    np.testing.assert_allclose(lost[1], [2, 2, 4 / 3, 1, 0, 0])
    np.testing.assert_allclose(lost[3], [4, 4, 2, 1, 0.5, 0.5])


def test_more_frames_than_any_capture_had_have_wider_intervals():
    at = np.array([4, 16])
    np.testing.assert_array_equal(losses(RECORD, at, 400), losses(RECORD, at))
    wide = losses(RECORD, at, 401)  # 1.5 times as far from 2 and 1 dB
    np.testing.assert_allclose(wide, [[-2.5, -2], [2, 1], [6.5, 4], [5, 1]])
    assert enough(RECORD, 1, 401) == 16
    assert enough(RECORD, 0.7, 401) == 401
    assert enough(RECORD, 0.7, 400) == 21


@pytest.mark.parametrize(
    ("loss", "frames"), [(9, 4), (4, 4), (2.001, 9), (1.999, 10), (1, 16), (0.5, 25), (0.49, 300)]
)
def test_the_smallest_number_within_the_bound_is_enough(loss, frames):
    assert enough(RECORD, loss, 300) == frames
    assert enough(RECORD, loss, 10) == min(frames, 10)


def test_a_number_that_later_ones_fall_behind_is_not_enough():
    assert enough(RECORD | {"bound": [0.0, 1.0, 0.5]}, 0.9, 300) == 18  # 0.9 is at 1/sqrt(K) = 0.24


def test_the_table_has_what_was_measured_below_all_frames():
    known = shipped()
    table = HowMany.of(max(known["total"]))
    assert [row.frames for row in table.rows] == known["frames"]
    assert [row.psnr for row in table.rows] == [-lost for lost in known["median"]]
    for row in table.rows:
        assert row.low <= row.psnr <= row.high
        assert (row.better > 0.5) == (row.psnr > 0)
    assert not table.unlike
    assert HowMany.of(1 + max(known["total"])).unlike
    assert HowMany.of(21).rows == table.rows[: sum(k < 21 for k in known["frames"])]


def test_memory_is_counted_by_the_pixel():
    assert within(2_000_000, (64, 48)) == 20  # 98,304 bytes a frame
    assert within(196_608, (64, 48)) == 2
    with pytest.raises(ValueError, match=r"memory is 196607 bytes; allowed: 196608 or more.*Hint"):
        within(196_607, (64, 48))
    free = find(Auto(), 100, (64, 48))
    bound = find(Auto(memory=8 * 98_304 + 1), 100, (64, 48))
    roomy = find(Auto(memory=98_304 * 200, size=(64, 48)), 100, (8, 6))
    assert bound.enough == free.frames == roomy.frames > bound.frames == bound.within == 8


def test_a_gpu_takes_what_the_table_says():
    """9/10 of the memory, less the fixed part, over what a frame takes; worked by hand."""
    assert within(8e9, (960, 540), "gsplat") == 87  # 6.98e9 / 79.92e6
    assert within(8e9, (960, 540), "splatfacto") == 85  # 1,555,200 more a frame
    assert within(8e9, (64, 48), "nerfacto") == 2783  # 3.34e9 / 1.2e6
    assert within(8e9, (64, 48), "long-lrm") == 49  # 6.55e9 / 0.132e9
    with pytest.raises(
        ValueError, match=r"memory is 3000000000 bytes; allowed: 4291555556 or more"
    ):
        within(3_000_000_000, (64, 48), "nerfacto")
    with pytest.raises(ValueError, match="trainer is 'nerf'; allowed: splats, gsplat"):
        within(8e9, (64, 48), "nerf")


@pytest.mark.parametrize("trainer", NEEDS)
@pytest.mark.parametrize("frames", [2, 3, 30, 1000])
def test_what_is_allowed_fits_and_one_more_would_not(trainer, frames):
    memory = NEEDS[trainer].of(frames, (960, 540)) + 1
    assert within(memory, (960, 540), trainer) == frames
    assert NEEDS[trainer].of(frames + 1, (960, 540)) > memory


@pytest.mark.parametrize("loss", [0, -0.1, np.inf, np.nan])
def test_a_loss_that_is_none_is_refused(loss):
    with pytest.raises(ValueError, match="allowed: numbers above 0, in dB"):
        Auto(loss)


@pytest.fixture
def ring(tmp_path):
    write_ring(tmp_path / "capture")
    return fsel.read_capture(tmp_path / "capture", long_side=64)


def test_the_picks_are_those_of_the_number_that_is_found(ring):
    chosen = fsel.select(ring, "auto", "every:6", patience=0)
    found = chosen.budget
    assert found == find(Auto(), 20, ring.size)  # of 24, without those held out
    every = fsel.select(ring, found.frames, "every:6", patience=0)
    assert (chosen.names, every.budget) == (every.names, None)
    assert fsel.how_many(ring) == HowMany.of(24)
    uniform = fsel.select(ring, fsel.Auto(10), method="uniform")  # its picks are not nested
    assert len(uniform) == uniform.budget.enough == min(shipped()["frames"])


def test_what_is_kept_fits_the_memory(ring):
    memory = 5 * 64 * 48 * SPLAT + 7
    chosen = fsel.select(ring, fsel.Auto(memory=memory), patience=0)
    assert len(chosen.names) == 5
    model = fsel.fit(ring, chosen.indices, opacity=0.0)
    assert model.bytes == SPLAT * model.primitives
    assert 0.5 * memory < model.bytes <= memory
    with pytest.raises(ValueError, match="memory is 9 bytes; allowed: 196608"):
        fsel.select(ring, Auto(memory=9))
