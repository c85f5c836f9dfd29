"""The fit behind `-k auto`: exact curves, and from captures to the record."""

import json

import numpy as np
import pandas as pd
from described_scene import write_scene

from fit_budget import COUNTS, SHIFTS, budget_curves, fit_budget, fit_worth
from fsel.selection.budget import predicted
from fsel.selectors.pretrained import FILES, FOLDER

WORTH = np.array([4.0, 2.0, 1.0])


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


def test_from_captures_to_the_record(tmp_path):
    scene = write_scene(tmp_path / "scene")
    curves, record = tmp_path / "curves.parquet", tmp_path / "budget.json"
    how = {"reconstruction": {"name": "splats", "long_side": 32, "settings": {}}, "config": "c"}
    budget_curves(scene, [FOLDER / FILES["fsel"]], curves, coverages=[25, 60], seed=0, **how)
    tried = pd.read_parquet(curves).groupby(["coverage", "repeat"])["k"].unique()
    assert len(tried) == 2 * 3
    assert all(list(counts) == list(COUNTS[:9]) for counts in tried)  # 4 to 30 of 31
    fit_budget([curves], record, scenes=["dl3dv/train00"], config="c")
    content = json.loads(record.read_text())
    assert content["provenance"]["made by"].startswith("least squares on 6 curves")
    assert len(content["worth"]) == 3
    assert min(content["worth"]) >= 0
    assert sum(content["worth"]) > 1
