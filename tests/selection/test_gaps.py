"""The largest gap between picks, by what is seen."""

import dataclasses

import numpy as np
import pytest
from small_captures import record_of, select

import fsel
from fsel.captures.quality.findings import MISPLACED, Finding, Health
from fsel.selection.request import SelectionRequest, checked_request
from fsel.selection.select import select_frames


def outcome_of(capture, picks):
    found = select_frames(checked_request(SelectionRequest(capture, len(picks), patience=0)))
    chosen = dataclasses.replace(found.selection, indices=np.array(picks))
    return dataclasses.replace(found, selection=chosen)


def test_the_largest_gap_is_by_what_is_seen(ring):
    """Of 24 cameras on a ring, three picks beside each other leave out the other side."""
    opened = fsel.read_capture(ring)
    picks = [0, 1, 2, 3, 4, 5, 6, 7]
    gap = outcome_of(opened, picks).gap
    assert gap.frame in (15, 16)  # eight steps from 7, and from 0
    assert gap.wide
    even = outcome_of(opened, [0, 6, 12, 18]).gap
    assert not even.wide
    assert even.shift == pytest.approx(even.usual)
    wrong = Health(tuple(Finding(i, MISPLACED, 2.0, 1.0, "") for i in range(12, 24)))
    left = dataclasses.replace(outcome_of(opened, picks), health=wrong)
    assert left.gap.frame == 11
    assert outcome_of(opened, [0, 12]).gap is None


def test_a_gap_is_told_and_shown(ring, tmp_path, capsys):
    (tmp_path / "never.txt").write_text("\n".join(f"frame_{i:03d}.jpg" for i in range(6, 24)))
    out = tmp_path / "out"
    assert select(ring, "-k", 5, "--never", tmp_path / "never.txt", "-o", out) == 0
    gap = record_of(out)["gap"]
    assert gap["wide"]
    assert gap["shift"] > 3 * gap["usual"]
    assert gap["name"] in capsys.readouterr().err
    assert gap["name"] in (out / "report.html").read_text().partition("Over time")[0]
