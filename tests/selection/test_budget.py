"""The number of frames: losses and memory by hand, and what `-k auto` keeps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_captures import write_ring

import fsel
from fsel.selection.budget import NEEDS, Auto, HowMany, enough, find, losses, shipped, within

SPLAT = 32  # bytes
RATES = {"low": [-1.0, 1.0], "median": [4.0, 4.0], "high": [8.0, 12.0], "bound": [6.0, 10.0]}
RECORD = {"frames": [4, 16], "total": [20, 400], **RATES}


def test_losses_are_rates_between_the_numbers_that_were_measured():
    """1/sqrt(K) is 1/2 and 1/4 at those, 1/3 at K = 9, of 100 frames 1/10."""
    third = 2 / 3  # of the way from 4 to 16
    rates = np.array([-1 + 2 * third, 4, 8 + 4 * third, 6 + 4 * third])
    lost = losses(RECORD, np.array([9, 16, 100, 25]), 100)
    np.testing.assert_allclose(lost[:, 0], rates * (1 / 3 - 1 / 10))
    np.testing.assert_allclose(lost[:, 1], [0.15, 0.6, 1.8, 1.5])
    np.testing.assert_allclose(lost[:, 2], 0, atol=1e-12)
    np.testing.assert_allclose(lost[:, 3], [0.1, 0.4, 1.2, 1.0])  # beyond: the last rates


def test_a_capture_of_more_frames_than_were_measured_has_a_wider_interval():
    """Of four times as many: twice as wide about the median, 4."""
    lost = losses(RECORD, np.array([4]), 1600)[:, 0] / (1 / 2 - 1 / 40)
    np.testing.assert_allclose(lost, [-6, 4, 12, 8])
    assert HowMany.of(10_000).unlike
    assert not HowMany.of(max(shipped()["total"])).unlike


@pytest.mark.parametrize(("loss", "frames"), [(1.0, 25), (0.999, 26), (9, 2), (1e-9, 100)])
def test_the_smallest_number_within_the_bound_is_enough(loss, frames):
    assert enough(RECORD, loss + 1e-12, 100) == frames  # 10 (1/5 - 1/10) is 1 dB


def test_a_number_that_later_ones_fall_behind_is_not_enough():
    record = RECORD | {"bound": [0.0, 10.0]}
    assert losses(record, np.array([4]), 100)[-1] == 0
    assert enough(record, 1.0 + 1e-12, 100) == 25


@settings(max_examples=40, deadline=None, derandomize=True)
@given(total=st.integers(3, 2000), loss=st.floats(0.05, 5), more=st.floats(0, 5))
def test_more_loss_keeps_no_more_and_more_frames_keep_no_fewer(total, loss, more):
    counts = enough(shipped(), loss, total), enough(shipped(), loss, total + 1)
    assert enough(shipped(), loss + more, total) <= counts[0] <= counts[1]
    assert 2 <= counts[0] <= total


def test_the_table_has_what_was_measured_and_goes_on_below_all_frames():
    table = HowMany.of(310)
    frames = [row.frames for row in table.rows]
    known = shipped()["frames"]
    assert frames[: len(known)] == known
    assert max(frames) < 310 < 1.6 * max(frames)
    for row in table.rows:
        assert row.low <= row.psnr <= row.high
        assert (row.better > 0.5) == (row.psnr > 0)
    assert len(str(table).splitlines()) == 1 + len(table.rows) + table.unlike
    assert HowMany.of(5).rows == ()


def test_memory_is_counted_by_the_pixel():
    assert within(2_000_000, (64, 48)) == 20  # 98,304 bytes a frame
    assert within(196_608, (64, 48)) == 2
    with pytest.raises(ValueError, match=r"memory is 196607 bytes; allowed: 196608 or more.*Hint"):
        within(196_607, (64, 48))
    free = find(Auto(0.01), 100, (64, 48))
    bound = find(Auto(0.01, 8 * 98_304 + 1), 100, (64, 48))
    roomy = find(Auto(0.01, 98_304 * 200, (64, 48)), 100, (8, 6))
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
    chosen = fsel.select(ring, "auto", "every:6")
    found = chosen.budget
    assert found == find(Auto(), 20, ring.size)  # of 24, without those held out
    every = fsel.select(ring, found.frames, "every:6")
    assert (chosen.names, every.budget) == (every.names, None)
    assert fsel.how_many(ring) == HowMany.of(24)
    uniform = fsel.select(ring, fsel.Auto(3), method="uniform")  # its picks are not nested
    assert len(uniform) == uniform.budget.enough < found.frames


def test_what_is_kept_fits_the_memory(ring):
    memory = 5 * 64 * 48 * SPLAT + 7
    chosen = fsel.select(ring, fsel.Auto(1e-6, memory))
    assert len(chosen.names) == 5
    model = fsel.fit(ring, chosen.indices, opacity=0.0)
    assert model.bytes == SPLAT * model.primitives
    assert 0.5 * memory < model.bytes <= memory
    with pytest.raises(ValueError, match="memory is 9 bytes; allowed: 196608"):
        fsel.select(ring, Auto(memory=9))
