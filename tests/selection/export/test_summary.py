"""The sentence that says what was selected."""

from types import SimpleNamespace

import numpy as np
import pytest

from fsel.captures.quality.findings import Finding, Health
from fsel.selection.export.record import summary
from fsel.selection.validation import CandidateScore, ValidationResult


@pytest.mark.parametrize(
    ("gains", "kept", "on_targets", "parts"),
    [
        ((0, -0.3), "a", False, ["Uniform sampling is"]),
        ((0, 1.26), "b", False, ["By b, 1.3 dB", "uniform sampling"]),
        ((0, 1.26), "b", True, ["By b, 1.3 dB", "fsel"]),
        ((0, np.nan), "a", False, ["Uniform sampling is kept", "too few"]),
        (None, "", False, ["3 frames by fsel alone", "--patience"]),
    ],
)
def test_one_sentence_says_what_was_kept_and_left_out(gains, kept, on_targets, parts):
    frames, tried = np.arange(3), None
    if gains:
        both = zip("ab", gains, strict=True)
        trials = tuple(CandidateScore(n, frames, g, g, 0, 0.1, 9, 3) for n, g in both)
        tried = ValidationResult(trials, kept, 6, cut=False, on_targets=on_targets)
    found = [Finding(frame, kind, 9, 6, "") for frame, kind in ((4, "blurred"), (5, "duplicate"))]
    outcome = SimpleNamespace(
        selection=type("Picks", (), {"__len__": lambda _: 3, "tried": tried})(),
        targets=SimpleNamespace(frames=np.arange(5, 9), bad=np.array([4])),
        health=Health(tuple(found)),
        method=SimpleNamespace(name="fsel"),
    )
    said = summary(outcome)
    assert all(part in said for part in parts), said
    assert said.endswith("1 blurred frame was left out.")
