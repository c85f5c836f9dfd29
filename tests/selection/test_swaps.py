"""Picks made better by swaps: what is kept, when it ends, how it is requested."""

from types import SimpleNamespace

import numpy as np
import pytest
from small_captures import record_of, select, write_ring

import fsel
from fsel.selection import swaps as swapping
from fsel.selection.refine import Refine, Swapped
from fsel.selection.swaps import swaps


def test_swaps_climb_to_the_best_subset_and_end():
    rng = np.random.default_rng(0)
    best = list(swaps(lambda picks: picks.sum(), np.arange(3), np.arange(8), np.arange(8), rng))
    assert best[0].tried == 1
    assert best[0].gain == 0
    assert sorted(best[-1].picks.tolist()) == [5, 6, 7]
    assert best[-1].gain == 15
    gains = [step.gain for step in best]
    assert gains == sorted(gains)
    assert [step.tried for step in best] == list(range(1, len(best) + 1))


def test_a_swapped_frame_takes_the_place_of_the_one_that_left():
    rng = np.random.default_rng(1)
    pool = np.array([2, 3, 4, 9])
    step = list(swaps(lambda picks: float(9 in picks), np.array([4, 2, 3]), pool, pool, rng))[-1]
    assert len(np.flatnonzero(step.picks != [4, 2, 3])) == 1
    assert step.picks[step.picks != [4, 2, 3]].tolist() == [9]


def test_without_a_free_frame_the_start_is_kept():
    every = np.arange(4)
    steps = list(swaps(lambda picks: 0.0, every, every, every, np.random.default_rng(0)))
    assert len(steps) == 1
    assert steps[0].picks.tolist() == [0, 1, 2, 3]


@pytest.fixture
def ring(tmp_path):
    write_ring(tmp_path / "ring", frames=24)
    return tmp_path / "ring"


def test_selecting_with_swaps_ends_when_asked_and_keeps_held_out_frames_out(ring):
    capture = fsel.read_capture(ring, long_side=32)
    plain = fsel.select(capture, 5, "every:4")
    seen = []

    def progress(best, gone):
        seen.append(best.tried)
        return best.tried < 12

    chosen = fsel.select(capture, 5, "every:4", refine=Refine(1e6, progress))
    assert seen == list(range(1, 13))
    assert chosen.swapped.tried == 12
    assert chosen.swapped.gain >= 0
    assert len(set(chosen.indices)) == 5
    assert not np.isin(chosen.indices, np.arange(0, len(capture), 4)).any()
    same = chosen.indices == plain.indices
    np.testing.assert_array_equal(chosen.scores[same], plain.scores[same])
    assert np.isnan(chosen.scores[~same]).all()


def test_the_time_of_swaps_runs_once_the_first_reconstruction_has_compiled(ring, monkeypatch):
    clock = [1.0]

    def slowly(*_):
        for tried in range(1, 9):
            clock[0] += 60 if tried == 1 else 1
            yield Swapped(np.arange(3), 0.0, tried)

    monkeypatch.setattr(swapping, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(swapping, "problem_swaps", slowly)
    problem = SimpleNamespace(capture=fsel.read_capture(ring, long_side=32), whole=False)
    assert swapping.refined(problem, np.arange(3), Refine(3.0), 0).tried == 1 + 4


@pytest.mark.parametrize("better", [True, False])
def test_swaps_that_fresh_frames_do_not_confirm_are_taken_back(ring, monkeypatch, better):
    capture = fsel.read_capture(ring, long_side=32)
    problem = SimpleNamespace(capture=capture, whole=True, observed=np.arange(24))
    before, after = np.array([12, 0, 6]), np.array([12, 0, 7])
    seeds = []

    def small_fits(of, frames, selections):
        assert of is capture
        assert not np.isin(frames, before).any()
        assert [own.tolist() for own in selections.values()] == [[0, 6, 12], [0, 7, 12]]

        def score(picks, seed):
            seeds.append(seed)
            ahead = 7 in picks and (better or seed is None)  # else by `splats` alone
            return np.tile([20.0 + ahead, 0.5], (len(frames), 1))

        return score

    monkeypatch.setattr(swapping, "small_fits", small_fits)
    found = swapping.confirmed(problem, before, Swapped(after, 2.0, 9))
    assert found.kept is better
    assert found.picks.tolist() == (after if better else before).tolist()
    assert found.fresh.gain == pytest.approx(1.0 if better else 0.5)
    assert found.gain == 2.0
    assert 0 not in seeds  # of the fits that scored the swaps
    nothing = Swapped(before[::-1], 0.0, 9)
    assert swapping.confirmed(problem, before, nothing) is nothing


def test_no_time_and_too_few_picks_are_refused(ring):
    with pytest.raises(ValueError, match="refine is 0 s; allowed: more than 0"):
        Refine(0)
    with pytest.raises(ValueError, match="2 picks; allowed: 3 or more"):
        fsel.select(fsel.read_capture(ring), 2, refine=1.0)


def test_the_command_says_what_swaps_gained(ring, tmp_path, capsys):
    assert select(ring, "-k", 5, "--refine", "0.3s", "-o", tmp_path / "out") == 0
    said = capsys.readouterr().out
    record = record_of(tmp_path / "out")
    assert record["refined"]["tried"] >= 1
    assert record["refined"]["reconstructor"] == "gaussians"
    gain, tried = (record["refined"][what] for what in ("gain", "tried"))
    assert f"{gain:+.2f} dB by gaussians in {tried} reconstructed" in said
    fresh = record["refined"]["fresh"]
    assert ("frames that scored no swap" in said) == (fresh is not None)
    assert record["refined"]["kept"] is not ("swapped back" in said)


def test_swaps_are_scored_by_the_reconstructor_that_is_named(ring, tmp_path, capsys):
    asked = ("-k", 4, "--refine", "0.1s", "-o", tmp_path / "out", "--force")
    assert select(ring, *asked, "--targets", "every:8") == 0
    assert "dB by splats in" in capsys.readouterr().out
    assert select(ring, *asked, "--reconstructor", "splats") == 0
    assert "dB by splats in" in capsys.readouterr().out
    assert record_of(tmp_path / "out")["refined"]["reconstructor"] == "splats"
    with pytest.raises(ValueError, match="refine is 'external'; allowed: splats, gaussians"):
        Refine(1.0, reconstructor="external")
    assert select(ring, "-k", 4, "--reconstructor", "splats", "-o", tmp_path / "no") == 1
    assert "scores swaps alone. Hint: --refine 30s" in capsys.readouterr().err


def test_unopened_images_are_refused(ring, tmp_path, capsys):
    assert select(ring, "-k", 5, "--refine", "1s", "--geometry-only", "-o", tmp_path / "out") == 1
    assert "--refine reconstructs from images" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
