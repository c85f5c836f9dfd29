"""Selections scored on the capture itself: who is kept, by how many fits, when the time is over."""

from types import SimpleNamespace

import numpy as np
import pytest
from small_captures import record_of, run, select

import fsel
from fsel.core.limits import THREADS
from fsel.selection import halving
from fsel.selection.candidates import EVEN
from fsel.selection.halving import FIT_DEVIATION, SuccessiveHalving, compared
from fsel.selection.validation import STATED, WHOLE, TimeBudget

FRAMES = np.arange(40)
EVENLY, OTHER, THIRD = np.array([0, 13, 26, 39]), np.array([1, 2, 3, 4]), np.array([5, 6, 7, 8])


ENDLESS = TimeBudget(1e6)


def race(gains, share=2, budget=ENDLESS, ssim=0.0, log=None, splats=None, bar=WHOLE):
    """Run with picks whose frames are all scored alike: 20 dB, and what `gains` adds by name.

    `splats` has those of that reconstructor, `gains` those of both where it is None.
    """
    picks = {EVEN: EVENLY, "other": OTHER, "third": THIRD}

    def score(frames, seed):
        name = next(name for name, own in picks.items() if np.array_equal(own, frames))
        if log is not None:
            log.append((name, seed))
        own = gains if seed is not None or splats is None else splats
        return np.tile([20 + own.get(name, 0.0), 0.5 + (name != EVEN) * ssim], (40, 1))

    return SuccessiveHalving(score, picks, FRAMES, bar).run(share, budget)


def test_the_best_of_those_ahead_is_kept():
    found = race({"other": 1.0, "third": 2.0})
    assert found.kept == "third"
    np.testing.assert_array_equal(found.frames, THIRD)
    assert [trial.name for trial in found.trials] == [EVEN, "other", "third"]
    assert found.trials[2].gain == pytest.approx(2.0)
    assert found.trials[2].validation == 40 - 8


def test_on_targets_gaussians_alone_decide_and_little_keeps_the_rule():
    log = []
    asked = {"log": log, "splats": {"other": -9.0}, "bar": STATED}
    found = race({"other": 0.3, "third": 0.25}, ssim=-0.01, **asked)
    assert (found.kept, found.on_targets) == ("other", True)
    assert found.trials[1].gain == pytest.approx(0.3)
    assert [seed for name, seed in log if name == "other"] == list(range(8))
    assert [seed for name, seed in log if name == "third"] == [0, 1, 2, 3]
    assert race({"other": 0.1}, bar=STATED).kept == EVEN


@pytest.mark.parametrize(("agree", "expected"), [(True, "exchanges"), (False, EVEN)])
def test_picks_are_exchanged_where_two_fits_gain(agree, expected):
    near = np.arange(20, 30)

    def score(frames, seed):
        return np.tile([20 + frames.sum() / 100 * (agree or not seed), 0.5], (40, 1))

    race = SuccessiveHalving(score, {EVEN: EVENLY}, FRAMES, STATED, near, np.array([13]))
    found = race.run(1, ENDLESS, rounds=9)
    assert found.kept == expected
    assert 2 + 9 * 8 < found.fits + 2 <= 2 + 9 * 9
    if agree:
        assert found.frames.tolist() == [13, 28, 29, 39]  # of 26, 28 and 29 the best two


def test_little_gain_and_worse_structure_keep_every_nth_frame():
    assert race({"other": 0.4}).kept == EVEN
    assert race({"other": 3.0}, ssim=-0.01).kept == EVEN
    assert race({"other": 3.0}, ssim=0.01).kept == "other"


def test_what_one_reconstructor_alone_prefers_is_not_kept():
    log = []
    assert race({"other": 3.0}, splats={"other": -0.1}, log=log).kept == EVEN
    assert {seed for _, seed in log} == {None}  # and `gaussians` are not fitted for it
    assert race({"other": -0.1}, splats={"other": 3.0}).kept == EVEN
    assert race({"other": 0.1}, splats={"other": 3.0}).kept == EVEN
    found = race({"other": 0.3, "third": 2.0}, splats={"other": 3.0, "third": 0.6})
    assert found.kept == "other"
    assert [trial.gain for trial in found.trials] == pytest.approx([0.0, 1.65, 1.3])
    assert [trial.least for trial in found.trials] == pytest.approx([0.0, 0.3, 0.6])


def test_heats_make_new_fits_and_the_hopeless_leave():
    log = []
    race({"other": 2.0, "third": -5.0}, log=log)
    assert [seed for name, seed in log if name == "other"] == [None, *range(8)]
    assert [seed for name, seed in log if name == EVEN] == [None, *range(8)]
    assert [seed for name, seed in log if name == "third"] == [None]
    log = []
    race({"other": 2.0, "third": -2.0}, log=log, splats={"third": 1.0, "other": 1.0})
    assert [seed for name, seed in log if name == "third"] == [None, 0, 1]


def test_the_time_ends_it_and_is_seen():
    log, seen = [], []

    def watch(made, planned, gone):
        seen.append((made, planned))
        return made < 7

    found = race({"other": 9.0, "third": 1.0}, 1, TimeBudget(1e6, watch), log=log)
    assert (found.cut, found.fits, len(log)) == (True, 7, 7)
    assert seen[0] == (4, 3 + 3 + 3 + 4)
    late = race({"other": 9.0}, 1, TimeBudget(1e-9))
    assert (late.cut, late.fits, late.kept) == (True, 4, EVEN)
    assert not race({"other": 9.0}, 1, TimeBudget(1e-9, ceiling=np.inf)).cut


@pytest.mark.parametrize(("patience", "fits"), [(3.0, 2 + 1 + 19), (10.0, 2 + 32)])
def test_only_a_bound_far_above_the_patience_cuts_what_is_planned(patience, fits, monkeypatch):
    """A second a fit, after the first, which takes a minute to compile: 32 are planned."""
    clock = [1.0]
    monkeypatch.setattr(halving, "time", SimpleNamespace(perf_counter=lambda: clock[0]))

    def score(frames, seed):
        if seed is not None:
            clock[0] += 60 if clock[0] == 1 else 1
        return np.full((40, 2), 20.0 + np.array_equal(frames, OTHER))

    picks = {EVEN: EVENLY, "other": OTHER}
    found = SuccessiveHalving(score, picks, FRAMES).run(4, TimeBudget(patience))
    assert (found.fits, found.cut) == (fits, fits < 2 + 32)


def test_any_number_of_threads_gives_the_same_fits_and_choice(monkeypatch):
    gains, logs = {"other": 2.0, "third": 1.5}, []
    alone = race(gains)
    for count in (2, 3, 4):
        monkeypatch.setenv(THREADS, str(count))
        found = race(gains, log=logs)
        assert (found.kept, found.fits, found.cut) == (alone.kept, alone.fits, alone.cut)
        gains_of = [[trial.gain for trial in one.trials] for one in (found, alone)]
        np.testing.assert_array_equal(*gains_of)
    assert set(map(logs.count, logs)) == {3}  # each fit once


def test_a_race_that_ends_with_a_heat_makes_no_fit_more():
    stop = TimeBudget(1e6, lambda made, planned, gone: made < 5)
    found = race({"other": 9.0}, 1, stop)
    assert (found.fits, found.cut, found.kept) == (5, True, "other")
    found = race({"other": -9.0}, 1, stop, splats={"other": 1.0})
    assert (found.fits, found.cut, found.kept) == (5, False, EVEN)  # nothing was left to be tried


def test_selections_that_leave_too_few_validation_frames_are_not_fitted():
    log = []
    picks = {EVEN: np.arange(0, 40, 2), "odd": np.arange(1, 30, 2)}
    halving = SuccessiveHalving(lambda frames, seed: log.append(seed), picks, FRAMES)
    outcome = halving.run(2, ENDLESS)
    assert (outcome.kept, outcome.fits, log) == (EVEN, 0, [])


def test_the_error_is_that_of_stretches_and_of_fits():
    even = np.zeros((2, 24, 2))
    own = even.copy()
    own[:, :12, 0] = 2.0  # four of the eight stretches
    one = {"splats": (own[:1], even[:1])}
    of_frames = (8 / 7) / 8  # variance of four zeros and four twos is 8 / 7
    assert compared(one) == pytest.approx((1.0, 1.0, 0.0, np.sqrt(of_frames)))
    of_fits = FIT_DEVIATION**2 * (1 / 2 + 1 / 2) / 4  # half of the mean comes from these fits
    gain, least, ssim, error = compared(one | {"gaussians": (own + [1.0, -0.2], even)})
    assert (gain, least, ssim) == pytest.approx((1.5, 1.0, -0.2))
    assert error == pytest.approx(np.sqrt(of_frames + of_fits))


def test_what_few_frames_say_or_one_of_several_selections_is_chance():
    one = {EVEN: EVENLY, "other": OTHER}
    for n, picks, kept in ((28, one, "other"), (28, one | {"third": THIRD}, EVEN), (16, one, EVEN)):

        def score(frames, seed, n=n):
            gains = np.where(np.arange(n) // 4 % 2, 2.0, -0.2) * np.array_equal(frames, OTHER)
            return np.stack([20 + gains, np.full(n, 0.5)], axis=1)

        assert SuccessiveHalving(score, picks, FRAMES[:n]).run(1, ENDLESS).kept == kept


def test_without_patience_the_rule_picks_and_stated_requests_try_nothing(ring, quick_trials):
    capture = fsel.read_capture(ring, long_side=32)
    rule = fsel.select(capture, 5, method="fsel")
    assert rule.tried is None
    assert fsel.select(capture, 5, patience=0).names == rule.names
    assert fsel.select(capture, 5, "every:4", patience=0).tried is None
    assert [fsel.select(capture, k, "every:4").tried.seconds for k in (6, 7)] == [60, 10]
    assert fsel.select(capture, 5, "orbit").tried is None
    assert fsel.select(capture, fsel.Auto(memory=7 * 32 * 32 * 24)).tried is not None
    assert set(fsel.select(capture, 5, always=[1, 2]).indices) >= {1, 2}
    for stated, said in (
        ({"targets": "orbit"}, "patience is 2 s, but the views to render are given"),
        ({"targets": [3, 4]}, "3 or more frames as targets"),
        ({"method": "uniform"}, "the method is uniform"),
    ):
        with pytest.raises(ValueError, match=said):
            fsel.select(capture, **{"k": 5, "patience": 2} | stated)
    with pytest.raises(ValueError, match="patience is -1 s; allowed: 0 or more"):
        fsel.select(capture, 5, patience=-1)
    for few_or_nearly_all in (2, 17):
        assert fsel.select(capture, few_or_nearly_all, patience=5).tried is None


def test_what_is_kept_is_one_of_what_was_tried_and_always_the_same(ring):
    capture = fsel.read_capture(ring, long_side=32)
    first, again = (fsel.select(capture, 5, patience=TimeBudget(1e-9)) for _ in range(2))
    assert first.names == again.names
    assert first.tried.trials[0].name == EVEN
    np.testing.assert_array_equal(first.tried.trials[0].frames, np.round(np.linspace(0, 23, 5)))
    assert sorted(first.indices) == sorted(first.tried.frames)
    fits = sum(trial.fits for trial in first.tried.trials)
    assert first.tried.fits == fits <= len(first.tried.trials) + 1


def test_images_of_targets_that_are_frames_are_looked_at_by_default(ring, tmp_path, quick_trials):
    asked = ("--targets", "every:4", "-k", 5)
    assert select(ring, *asked, "-o", tmp_path / "rule") == 0
    assert record_of(tmp_path / "rule")["tried"] is None
    assert run("select", ring, *asked, "-o", tmp_path / "out") == 0
    tried = record_of(tmp_path / "out")["tried"]
    assert (tried["on_targets"], tried["selections"][0]["name"]) == (True, "fsel")
    assert tried["kept"] in {one["name"] for one in tried["selections"]}
    assert sum(one["fits"] for one in tried["selections"]) + 8 <= tried["fits"]


def test_images_that_stay_unopened_are_not_tried_on(ring, tmp_path, capsys):
    assert select(ring, "-k", 5, "--geometry-only", "-o", tmp_path / "out") == 0
    assert record_of(tmp_path / "out")["tried"] is None
    asked = ("-k", 5, "--geometry-only", "--patience", "3s", "-o", tmp_path / "no")
    assert select(ring, *asked) == 1
    assert "--geometry-only does not read" in capsys.readouterr().err
