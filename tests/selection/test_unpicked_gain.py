"""Gain on frames that are not picked: who is scored, over what."""

from types import SimpleNamespace

import numpy as np
import pytest

from fsel.selection.unpicked_gain import UnpickedGain, halves

N = 24


class Recorder:
    """A reconstructor whose models render every view in the grey level of their frames' sum."""

    def __init__(self):
        images = np.zeros((N, 11, 11, 3), np.uint8)
        self.capture = SimpleNamespace(images=images, view=lambda frames: frames)
        self.rendered = []

    def fit(self, frames):
        level = np.float32(frames.sum() / 255)

        def render(views):
            self.rendered.append(views.tolist())
            return np.full((len(views), 11, 11, 3), level)

        return SimpleNamespace(render=render)


def test_no_frame_is_scored_on_itself():
    recorder, even = Recorder(), np.arange(0, N, 2)
    gain = UnpickedGain(recorder, (even[3:], np.arange(1, N, 2)), np.array([0, 2, 4]))
    assert recorder.rendered == [even[3:].tolist()]
    assert gain(np.array([0, 2, 7])) == pytest.approx(20 * np.log10(6 / 9))  # levels of black
    assert gain(np.array([0, 2, 6])) == pytest.approx(20 * np.log10(6 / 8))
    assert recorder.rendered[-1] == even[4:].tolist()


@pytest.mark.parametrize("half", [0, 1])
def test_eight_frames_of_each_half_are_never_picked(half):
    frames = (np.arange(0, 18, 2), np.arange(1, 19, 2))
    gain = UnpickedGain(Recorder(), frames, np.array([18, 19, 20]))
    assert np.isfinite(gain(np.array([18, 19, frames[half][0]])))
    assert gain(np.array([18, *frames[half][:2]])) == -np.inf


def test_frames_that_confirm_swaps_score_none_of_them():
    scoring, others = halves(np.arange(23), np.array([0, 5, 6, 19]))
    assert scoring.tolist() == [1, 3, 7, 9, 11, 13, 15, 17, 20, 22]
    assert others.tolist() == [2, 4, 8, 10, 12, 14, 16, 18, 21]
    scoring, others = halves(np.arange(1000), np.array([3]))
    assert len(scoring) == len(others) == 96
    assert not np.isin(scoring, others).any()


def test_swaps_need_frames_that_are_not_picked():
    with pytest.raises(ValueError, match=r"17 of 22 frames are not picked.*allowed: 18 or more"):
        halves(np.arange(22), np.arange(5))
