"""What is said of a selection: how close its picks are to the views, and why they were kept."""

from types import SimpleNamespace

import numpy as np
import pytest
from selection_problems import in_line

from fsel.selection.export.record import summary
from fsel.selection.outcome import Outcome, Selection
from fsel.selection.targets import Targets
from fsel.selection.validation import CandidateScore, ValidationResult


def outcome(capture, picks, targets=(), tried=None):
    """What was selected from a capture by `uniform` or by what was tried."""
    names, frames = tuple(capture.names[i] for i in picks), np.array(targets, int)
    selection = Selection(names, np.array(picks), np.zeros(len(picks)), 0.0, capture, tried=tried)
    views = Targets(capture.view(frames), frames, "given frames", np.zeros(len(frames), bool))
    method = SimpleNamespace(name="uniform")
    return Outcome(capture, views, selection, None, method, None, {})


def test_the_shift_of_the_image_by_hand():
    """Of frames on a line that look alike, what the picks spread over stands for the depth."""
    line = in_line([0, 1, 2, 10])
    depth = 10 - 11 / 3
    fov = 2 * line.view(np.array([0])).half_fov[0]
    found = outcome(line, [3, 1, 0], targets=[0])
    np.testing.assert_allclose(found.shift[:, 0], [1, 1 / depth / fov, 0])
    np.testing.assert_allclose(found.mean_shift, found.shift[:, 0])


def test_every_pick_brings_the_views_closer(circle):
    picks = [2, 10, 18, *np.setdiff1d(np.arange(24), [1, 9, 17, 2, 10, 18])]
    found = outcome(circle, picks, targets=[1, 9, 17])
    np.testing.assert_array_equal(found.shift[:3].argmin(axis=1), [0, 1, 2])
    assert 0 < found.mean_shift[-1] <= found.mean_shift[0] <= 1
    assert (np.diff(found.mean_shift) <= 0).all()


@pytest.mark.parametrize(
    ("name", "scores", "said"),
    [
        ("fsel", (0.93, 0.86, 0.01, 0.6), {"fsel", "0.9 dB", "--patience 0 ", "--patience 30s"}),
        ("fsel", (0.93, 0.86, -0.01, 0.6), {"fsel", "0.9 dB", "--patience 0 "}),
        ("medoids", (0.93, 0.86, 0.01, 0.6), {"medoids", "0.9 dB", "--patience 30s"}),
        ("medoids", (-0.2, -0.3, 0.0, 0.1), set()),
    ],
)
def test_a_lead_that_is_not_enough_is_told_with_what_may_change_it(name, scores, said, circle):
    rows = np.arange(5)
    first = CandidateScore("uniform", rows, 0.0, 0.0, 0.0, 0.1, 20, 9)
    tried = ValidationResult(
        (first, CandidateScore(name, rows, *scores, 20, 9)), "uniform", 18, False
    )
    text = summary(outcome(circle, rows, tried=tried))
    known = {"fsel", "medoids", "0.9 dB", "--patience 0 ", "--patience 30s"}
    assert {word for word in known if word in text} == said
