"""How far training seeds spread: hand-worked values."""

import numpy as np
import pandas as pd
import pytest
from evaluation_files import FACTS, written

from fsel.experiments.paper.seedvar import seedvar
from fsel.report.summary import seed_spread


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
    problems, paths = written(tmp_path, {("s", "draw0"): runs | others})
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"datasets": {"d": "D"}, "budgets": [10, 20]}
    seedvar(paths, *outputs, problems=problems, **settings, facts=FACTS)
    numbers = pd.read_csv(outputs[1])
    np.testing.assert_allclose(numbers["std"], [0.1, 2.0])
    np.testing.assert_allclose(numbers["margin"], [20.1 - 20.5, 22.0 - 20.5])
    text = outputs[0].read_text()
    assert "training seeds ($3$)" in text
    assert "in $1$ of $2$ cells" in text
    assert r"D & 1 & 0.100 & 2.000 \\" in text


def test_one_seed_has_no_spread(tmp_path):
    problems, paths = written(
        tmp_path, {("s", "draw0"): {("less_is_more", 0, 10): 20.0, ("fvs", 0, 10): 19.0}}
    )
    settings = {"datasets": {"d": "D"}, "budgets": [10]}
    seedvar(
        paths, tmp_path / "t.tex", tmp_path / "t.csv", problems=problems, **settings, facts=FACTS
    )
    assert r"D & 1 & -- \\" in (tmp_path / "t.tex").read_text()
