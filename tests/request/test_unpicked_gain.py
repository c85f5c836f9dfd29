"""Gain on frames that are not picked: who is scored, over what."""

from types import SimpleNamespace

import numpy as np
import pytest

from fsel.request.unpicked_gain import UnpickedGain

N = 8


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
    recorder, problem = Recorder(), SimpleNamespace(observed=np.arange(N))
    gain = UnpickedGain(recorder, problem, np.array([0, 1, 2]))
    assert gain.frames.tolist() == [3, 4, 5, 6, 7]
    assert recorder.rendered == [[3, 4, 5, 6, 7]]
    assert gain(np.array([0, 1, 4])) == pytest.approx(20 * np.log10(3 / 5))  # levels of black
    assert recorder.rendered[-1] == [3, 5, 6, 7]
    assert gain(np.array([3, 4, 5, 6, 7])) == -np.inf


def test_swaps_need_a_frame_that_is_not_picked():
    with pytest.raises(ValueError, match="every frame is picked"):
        UnpickedGain(Recorder(), SimpleNamespace(observed=np.arange(N)), np.arange(N))
