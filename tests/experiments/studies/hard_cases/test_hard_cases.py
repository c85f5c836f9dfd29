"""Every hard case holds: finite numbers, no warning, the exact answer to rounding."""

import warnings

import numpy as np
import pandas as pd
import pytest

from fsel.experiments.studies import stability
from fsel.experiments.studies.hard_cases import Case, CaseOutcome, finite, observe


@pytest.mark.parametrize("case", stability.CASES.values(), ids=stability.CASES.keys())
def test_it_holds(case):
    finding = observe(case)
    assert finding.holds, f"{finding.observed}: error {finding.error:g}"


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        (lambda: np.ones(1) / np.zeros(1), "FloatingPointError: divide by zero"),
        (lambda: np.exp(np.full(1, 1e4)), "FloatingPointError: overflow"),
        (lambda: warnings.warn("careful", stacklevel=1), "UserWarning: careful"),
        (lambda: finite(np.array([1.0, np.nan, np.inf])), "FloatingPointError: 2 of 3 numbers"),
    ],
)
def test_a_fault_is_a_finding_that_does_not_hold(fault, told):
    finding = observe(Case("bad", "nothing", fault))
    assert finding.observed.startswith(told)
    assert not finding.holds


def test_the_table_has_a_row_for_every_case_faults_included(tmp_path, monkeypatch):
    cases = [
        Case("good", "50% of x_1", lambda: CaseOutcome("2 of 4", 1e-12, 1e-9)),
        Case("wrong", "two", lambda: CaseOutcome("three", 1.0, 1e-9)),
        Case("broken", "three", lambda: 1 / 0),
        Case("no number", "four", lambda: CaseOutcome("nan", np.nan, 1.0)),
    ]
    monkeypatch.setattr(stability, "CASES", {case.name: case for case in cases})
    stability.stability(tmp_path / "s.tex", tmp_path / "s.csv")
    table = pd.read_csv(tmp_path / "s.csv")
    assert table["holds"].tolist() == [True, False, False, False]
    assert table["observed"].tolist()[2] == "ZeroDivisionError: division by zero"
    text = (tmp_path / "s.tex").read_text()
    assert "1 of 4 pass" in text
    assert r"good & 50\% of x\_1 & 2 of 4 & 1.0e-12 & 1e-09 & -- \\" in text
