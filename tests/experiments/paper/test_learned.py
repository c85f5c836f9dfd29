"""What learning adds, and how far its seeds spread: hand-worked values."""

import numpy as np
import pandas as pd
import pytest
from evaluation_files import FACTS, written

from fsel.evaluation.latex import difference
from fsel.evaluation.summary import seed_spread
from fsel.experiments.paper.learned import handsign, seedvar


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


def made(table, folder, values, dataset) -> tuple[str, pd.DataFrame]:
    problems, paths = written(folder, values)
    outputs = folder / "t.tex", folder / "t.csv"
    settings = {"datasets": {"d": dataset}, "budgets": [10, 20], "facts": FACTS}
    table(paths, *outputs, problems=problems, **settings)
    return outputs[0].read_text(), pd.read_csv(outputs[1])


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
    text, numbers = made(handsign, tmp_path, learned_and_not([-1.0, 0.0, 0.4]), "A & B")
    np.testing.assert_allclose(numbers["mean"], [1.0, -0.2])
    assert numbers["reference"].unique().tolist() == ["untrained"]
    row = next(line for line in text.splitlines() if line.startswith(r"A \& B"))
    assert r"& 3 & $\mathbf{+1.00}$" in row
    assert r"$-0.20$" in row
    assert "ahead in $1$ of the $2$ cells; their mean is $+0.40$" in text
    for part in ("generated stand-ins", r"Tanks \& Temples", r"\texttt{splats} at 64 pixels"):
        assert part in text


def test_the_spread_is_of_dataset_means():
    # seed 0: scene a 20 and 22 (two draws), scene b 30: mean 25.5; seed 1: 21, 31 -> 26.5
    rows = [("a", 0, 0, 20.0), ("a", 1, 0, 22.0), ("b", 0, 0, 30.0)]
    rows += [("a", 0, 1, 20.0), ("a", 1, 1, 22.0), ("b", 0, 1, 32.0)]
    runs = pd.DataFrame(rows, columns=["scene", "draw", "seed", "psnr"]).assign(dataset="d", k=10)
    found = seed_spread(runs, "psnr").iloc[0]
    assert found["std"] == pytest.approx(np.std([25.5, 26.5], ddof=1))
    assert (found["seeds"], found["n"]) == (2, 2)


def test_the_spread_is_read_against_the_distance_to_the_strongest_baseline(tmp_path):
    runs = {
        ("less_is_more", s, k): 20.0 + s * size
        for s in range(3)
        for k, size in ((10, 0.1), (20, 2.0))
    }
    others = {("fvs", 0, k): 19.0 for k in (10, 20)} | {("nearest", 0, k): 20.5 for k in (10, 20)}
    text, numbers = made(seedvar, tmp_path, {("s", "draw0"): runs | others}, "D")
    np.testing.assert_allclose(numbers["std"], [0.1, 2.0])
    np.testing.assert_allclose(numbers["margin"], [20.1 - 20.5, 22.0 - 20.5])
    assert "training seeds ($3$)" in text
    assert "in $1$ of $2$ cells" in text
    assert r"D & 1 & 0.100 & 2.000 \\" in text


def test_one_seed_has_no_spread(tmp_path):
    runs = {(name, 0, k): 20.0 for name in ("less_is_more", "fvs") for k in (10, 20)}
    text, _ = made(seedvar, tmp_path, {("s", "draw0"): runs}, "D")
    assert r"D & 1 & -- & -- \\" in text
