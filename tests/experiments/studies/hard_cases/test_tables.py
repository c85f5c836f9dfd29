"""The table of hard cases."""

import pandas as pd

from fsel.experiments.studies import stability
from fsel.experiments.studies.hard_cases import CASES, Case, Finding


def raises():
    raise ValueError("no such frame")


def test_a_row_for_every_case_and_faults_are_told(tmp_path, monkeypatch):
    cases = [
        Case("good", "50% of x_1", lambda: Finding("2 of 4", 1e-12, 1e-9)),
        Case("wrong", "two", lambda: Finding("three", 1.0, 1e-9)),
        Case("broken", "three", raises),
    ]
    monkeypatch.setattr(stability, "CASES", {case.name: case for case in cases})
    stability.stability(tmp_path / "s.tex", tmp_path / "s.csv")
    table = pd.read_csv(tmp_path / "s.csv")
    assert table["holds"].tolist() == [True, False, False]
    assert table["observed"].tolist() == ["2 of 4", "three", "ValueError: no such frame"]
    text = (tmp_path / "s.tex").read_text()
    assert "1 of 3 hold" in text
    assert r"good & 50\% of x\_1 & 2 of 4 & 1.0e-12 & 1e-09 \\" in text


def test_hard_cases_with_cameras_offer_their_problem():
    assert sum(case.make is not None for case in CASES.values()) >= 16
