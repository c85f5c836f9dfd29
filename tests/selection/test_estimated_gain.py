"""Estimated gain of picks on targets without images: validation frames, what poses explain."""

from types import SimpleNamespace

import numpy as np
import pytest

from fsel.selection import estimated_gain
from fsel.selection.estimated_gain import Closeness, EstimatedGain

N = 8


class Recorder:
    """A reconstructor whose models render every view in the grey level of their frames' sum."""

    def __init__(self, images):
        self.capture = SimpleNamespace(images=images, view=lambda frames: frames)
        self.fitted, self.rendered = [], []

    def fit(self, frames):
        self.fitted.append(frames.tolist())
        shape = self.capture.images.shape[1:]
        level = np.float32(frames.sum() / 255)

        def render(views):
            self.rendered.append(views.tolist())
            return np.full((len(views), *shape), level)

        return SimpleNamespace(render=render)


def decibels(level):
    """PSNR of a grey level against black."""
    return 20 * np.log10(255 / level)


def views(*places):
    """Cameras in a row that look the same way."""
    centers = np.zeros((len(places), 3))
    centers[:, 0] = places
    return SimpleNamespace(centers=centers, axes=np.tile([0.0, 0, 1], (len(places), 1)))


class Row(SimpleNamespace):
    """Poses with a length."""

    def __len__(self):
        return len(self.centers)


def problem(*targets):
    """Frames 0..7 a unit apart, all observed, and targets between them."""
    return SimpleNamespace(
        capture=views(*range(N)), targets=Row(**vars(views(*targets))), observed=np.arange(N)
    )


@pytest.fixture
def recorder():
    return Recorder(np.zeros((N, 11, 11, 3), np.uint8))


@pytest.fixture
def three(monkeypatch):
    """Three validation frames a target, and all are rendered."""
    monkeypatch.setattr(estimated_gain, "VALIDATION", 3)
    monkeypatch.setattr(estimated_gain, "FIRST", 1.0)


def close(view, *picks):
    """Of places in a row whose largest distance is 5.6: from the target at 5.6 to frame 0."""
    return sum(1 / (abs(view - pick) / 5.6 + 0.1) for pick in picks)


def test_closeness_leaves_a_frame_out_where_it_is_looked_at_itself():
    closeness = Closeness.of(problem(5.6), np.array([4, 6]))
    values = closeness(np.array([1, 4]))
    np.testing.assert_allclose(values, [close(4, 1), close(6, 1, 4), close(5.6, 1, 4)])


@pytest.mark.usefixtures("three")
def test_a_frame_is_never_scored_on_itself(recorder):
    gain_of = EstimatedGain(recorder, problem(5.6), np.array([5, 2, 1]))
    assert gain_of.frames.tolist() == [5, 6, 7]
    # frames 6 and 7 are rendered from 1 + 2 + 5, frame 5 from 1 + 2 grey levels
    assert recorder.fitted == [[1, 2, 5], [1, 2]]
    assert recorder.rendered == [[6, 7], [5]]
    np.testing.assert_allclose(gain_of.base, decibels(np.array([3, 8, 8])), atol=1e-5)


@pytest.mark.usefixtures("three")
def test_the_gain_is_what_poses_explain_of_the_target_and_what_frames_gain_beyond_it(recorder):
    gain_of = EstimatedGain(recorder, problem(5.6), np.array([5, 2, 1]))
    gain = gain_of(np.array([0, 6, 1]))  # frames 5 and 7 are scored

    def explained(view, before):
        return 7 * np.log(close(view, 0, 1, 6) / close(view, *before))

    beyond5 = decibels(7) - decibels(3) - explained(5, [1, 2])
    beyond7 = decibels(7) - decibels(8) - explained(7, [1, 2, 5])
    expected = explained(5.6, [1, 2, 5]) + (beyond5 + beyond7) / 2
    assert gain == pytest.approx(expected, abs=1e-5)


@pytest.mark.usefixtures("three")
def test_every_target_counts_alike(recorder):
    start, picks = np.array([5, 2, 1]), np.array([0, 3, 4])
    gains = []
    for places in ((1.2,), (5.6,), (1.2, 5.6)):
        gain_of = EstimatedGain(recorder, problem(*places, 5.8), start)
        gains.append(gain_of(picks))
    alone = EstimatedGain(recorder, problem(5.8), start)(picks)
    first, second = 2 * gains[0] - alone, 2 * gains[1] - alone
    assert 3 * gains[2] == pytest.approx(first + second + alone, abs=1e-5)


@pytest.mark.usefixtures("three")
def test_where_every_validation_frame_is_picked_poses_alone_count(recorder):
    gain_of = EstimatedGain(recorder, problem(5.6), np.array([5, 2, 1]))
    gain = gain_of(np.array([5, 6, 7]))
    assert gain == pytest.approx(7 * np.log(close(5.6, 5, 6, 7) / close(5.6, 1, 2, 5)), abs=1e-5)


def test_the_frames_that_a_swap_concerns_least_wait_for_the_others(recorder, monkeypatch):
    monkeypatch.setattr(estimated_gain, "VALIDATION", 5)
    gain_of = EstimatedGain(recorder, problem(5.6), np.array([4, 2, 1]))
    assert gain_of.frames.tolist() == [3, 4, 5, 6, 7]
    recorder.rendered.clear()
    assert gain_of(np.array([4, 3, 1])) < 0  # brighter, so worse
    assert recorder.rendered == [[7]]  # 30 % of 5, 6 and 7, rounded up
    assert gain_of.best.picks.tolist() == [4, 2, 1]
    recorder.rendered.clear()
    gain = gain_of(np.array([4, 0, 1]))
    assert recorder.rendered == [[3, 7], [6, 5]]
    assert gain > 0
    assert gain_of.best.gain == gain
    assert gain_of.best.picks.tolist() == [4, 0, 1]


def test_a_frame_that_was_a_pick_is_always_rendered(recorder, monkeypatch):
    monkeypatch.setattr(estimated_gain, "VALIDATION", 5)
    gain_of = EstimatedGain(recorder, problem(5.6), np.array([4, 2, 1]))
    recorder.rendered.clear()
    gain_of(np.array([7, 2, 1]))
    assert recorder.rendered == [[4, 5]]  # 5 stands between the frames that change


def test_the_start_gains_nothing(recorder):
    assert EstimatedGain(recorder, problem(5.6), np.array([0, 2, 7]))(np.array([0, 2, 7])) == 0
