"""The adaptive budget beside fixed ones: the fit, the comparison, from a capture to the table."""

import json

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene

from fsel.experiments.studies.budget import (
    MEAN,
    at_same_number,
    budget,
    evaluate_budgets,
    means,
)
from fsel.experiments.studies.budget import TRIALS as REQUESTS
from fsel.experiments.studies.budget_curves import (
    COUNTS,
    SHIFTS,
    TRIALS,
    fit_budget,
    fit_worth,
)
from fsel.selection.budget import predicted
from fsel.selectors.pretrained import FILES, FOLDER

WORTH = np.array([4.0, 2.0, 1.0])
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
FACTS = {
    "embedded": ["DL3DV"], "real": [], "reconstructor": "splats", "long_side": 32,
    "descriptor": "lab_hog", "draws": 1,
}  # fmt: skip


def curves_of(reach, scenes=("a", "b"), last=20):
    """Exact curves under WORTH: shifts fall in proportion to k, to zero at `reach` picks."""
    tables = []
    for number, scene in enumerate(scenes):
        for coverage, end in reach.items():
            k = np.arange(last + 1)
            left = np.maximum(1 - k / end, 0)
            table = pd.DataFrame({"dataset": scene, "scene": "s", "coverage": coverage, "k": k})
            table[SHIFTS] = np.column_stack([left, left**2, left**3])
            quality = predicted(table[SHIFTS].to_numpy(), WORTH)
            # every scene at its own level
            tables.append(table.assign(repeat=0, psnr=20 + number + quality))
    return pd.concat(tables, ignore_index=True)


def test_the_fit_finds_what_made_the_curves():
    np.testing.assert_allclose(fit_worth(curves_of({25: 6, 100: 15})), WORTH, rtol=1e-6)


def test_means_are_over_draws_then_over_scenes():
    rows = []
    for scene, draw, k, psnr in (("a", 0, 4, 20.0), ("a", 1, 6, 22.0), ("b", 0, 9, 27.0)):
        rows.append({"scene": scene, "draw": draw, "rule": "auto", "k": k, "psnr": psnr})
        for budget_, level in ((4, 20.0), (8, 24.0)):
            rows.append({**rows[-1], "rule": "fixed", "k": budget_, "psnr": level})
    found = means(pd.DataFrame(rows).assign(seconds=0.1, bytes=32), "scene")
    auto = found[found["rule"] == "auto"].set_index("request")
    assert auto["k"].to_dict() == {"a": 5, "b": 9, MEAN: 7}
    assert auto.loc[MEAN, "psnr"] == 24
    assert at_same_number(found) == (7, 23)
    frames, psnr = at_same_number(found.replace({"budget": 8}, 6))
    assert (frames, np.isnan(psnr)) == (7, True)  # beyond 4 and 6


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors and one draw of targets."""
    return write_scene(tmp_path_factory.mktemp("scene"))


def test_from_a_capture_to_the_table(scene, tmp_path):
    curves, fitted = tmp_path / "curves.parquet", tmp_path / "budget.json"
    common = {"reconstruction": RECONSTRUCTION, "seed": 0, "config": "c"}
    weights, picks = FOLDER / FILES["fsel"], tmp_path / "picks.parquet"
    known = {"settings": {"coverages": [25, 60], "seed": 0}, "config": "c"}
    TRIALS.select([scene], scene / "descriptors.parquet", [weights], picks, **known)
    measuring = {"reconstruction": RECONSTRUCTION, "metrics": ["psnr"]}
    TRIALS.evaluate([scene], [picks], curves, **known, **measuring)
    table = pd.read_parquet(curves)
    tried = table.groupby(["coverage", "repeat"])["k"].unique()
    assert all(list(counts) == list(COUNTS[:9]) for counts in tried)  # 4 to 30 of 31
    scenes = [("dl3dv", "train00")]
    fit_budget([scene], [picks], [curves], fitted, scenes=scenes, config="c")
    worth = json.loads(fitted.read_text())["worth"]
    assert len(worth) == 3
    assert min(worth) >= 0
    assert sum(worth) > 1
    measured = tmp_path / "budgets.parquet"
    auto = {"threshold": 0.05, "memory": 6 * 32 * 24 * 32}
    asked, splits = {"coverages": [25], "seed": 0}, [scene / "split.parquet"]
    how = {"splits": splits, "settings": asked, "config": "c"}
    REQUESTS.select([scene], scene / "descriptors.parquet", [weights], picks, **how)
    tried = {**asked, **common, "budgets": [5, 10], "auto": auto}
    evaluate_budgets(scene, splits, fitted, picks, measured, **tried)
    rows = pd.read_parquet(measured).set_index(["coverage", "rule"])
    assert (rows.loc[[(0, "memory"), (25, "memory")], "k"] <= 6).all()
    assert (rows["bytes"] <= rows["k"] * 32 * 24 * 32).all()
    outputs = tmp_path / "budget.tex", tmp_path / "budget.csv"
    settings = {"scenes": [("dl3dv", "evaluation00")], "datasets": {"dl3dv": "DL3DV"}}
    budget([measured], *outputs, **settings, auto=auto, facts=FACTS)
    text = outputs[0].read_text()
    assert text.count(r"\begin{table}") == 2
    assert "DL3DV, 00 & " in text
    assert r"25\% & " in text
    numbers = pd.read_csv(outputs[1])
    assert set(numbers["rule"]) == {"auto", "memory", "fixed"}
    kept = rows.loc[(25, "auto"), "k"].item()
    of_sizes = numbers[(numbers["requests"] == "sizes") & (numbers["rule"] == "auto")]
    assert of_sizes["k"].eq(kept).all()
    assert list(of_sizes["request"]) == ["25%", MEAN]
