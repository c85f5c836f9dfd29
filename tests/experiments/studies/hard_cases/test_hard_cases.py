"""Every hard case holds: finite numbers, no warning, the exact answer to rounding."""

import warnings

import numpy as np
import pytest

from fsel.experiments.studies.hard_cases import CASES, Case, Finding, observe, strict
from fsel.experiments.studies.hard_cases.case import finite


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_it_holds(case):
    with strict():
        finding = case.run()
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


def test_an_error_that_is_no_number_does_not_hold():
    assert not Finding("", np.nan, 1.0).holds
    assert Finding("", 1.0, 1.0).holds
