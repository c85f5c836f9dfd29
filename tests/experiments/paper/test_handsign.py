"""What learning adds: hand-worked values."""

import numpy as np
import pandas as pd
import pytest
from evaluation_files import FACTS, written

from fsel.experiments.paper.handsign import handsign
from fsel.report.latex import difference


@pytest.mark.parametrize(
    ("bounds", "text"),
    [
        ((0.5, 0.1, 0.9), r"$\mathbf{+0.50}$ {\tiny$[+0.10,+0.90]$}"),
        ((0.5, -0.1, 0.9), r"$+0.50$ {\tiny$[-0.10,+0.90]$}"),
        ((-0.5, -0.9, -0.1), r"$\mathbf{-0.50}$ {\tiny$[-0.90,-0.10]$}"),
        ((0.5, np.nan, np.nan), "$+0.50$"),
    ],
)
def test_a_difference_inside_its_interval_is_not_bold(bounds, text):
    assert difference(*bounds) == text


def learned_and_not(shift):
    """Three scenes: learned minus untrained is one dB at K = 10, `shift` of the scene at 20."""
    return {
        (f"s{i}", "draw0"): {
            ("less_is_more", 0, 10): 21.0 + i,
            ("untrained", 0, 10): 20.0 + i,
            ("less_is_more", 0, 20): 25.0 + i + shift[i],
            ("untrained", 0, 20): 25.0 + i,
            ("fvs", 0, 10): 30.0,
        }
        for i in range(3)
    }


def test_learned_minus_untrained(tmp_path):
    problems, paths = written(tmp_path, learned_and_not([-1.0, 0.0, 0.4]))
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"datasets": {"d": "A & B"}, "budgets": [10, 20]}
    handsign(paths, *outputs, problems=problems, **settings, facts=FACTS)
    numbers = pd.read_csv(outputs[1])
    np.testing.assert_allclose(numbers["mean"], [1.0, -0.2])
    assert numbers["reference"].unique().tolist() == ["untrained"]
    text = outputs[0].read_text()
    row = next(line for line in text.splitlines() if line.startswith(r"A \& B"))
    assert r"& 3 & $\mathbf{+1.00}$" in row
    assert r"$-0.20$" in row
    assert "ahead in $1$ of the $2$ cells; their mean is $+0.40$" in text
    for part in ("generated stand-ins", r"Tanks \& Temples", r"\texttt{splats} at 64 pixels"):
        assert part in text
