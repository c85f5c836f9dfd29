"""The budget sweep's table."""

import numpy as np
import pandas as pd
import pytest
from evaluation_files import FACTS

from fsel.evaluation.summary import read_csv
from fsel.metrics import METRICS
from fsel.selectors.baselines import METHODS
from fsel.stages.ksweep import caption, ksweep

SEARCHED = {"search_k": 20, "draws": 3, "oracle_draws": 1, "oracle_dataset": "R & D"}


def test_the_sweep_table_prints_means_of_the_evaluations(swept, tmp_path):
    paths = [draw / "evaluation.parquet" for draw in swept]
    table, numbers, differences = (tmp_path / name for name in ("k.tex", "k.csv", "d.csv"))
    asked = {"datasets": {"d": "D"}, "budgets": [3, 5], "metrics": METRICS, "facts": FACTS}
    problems = [f"d/s/{draw.name}" for draw in swept]
    ksweep(paths, [], table, numbers, differences, problems=problems, searched=[], **asked)
    tables = [pd.read_parquet(path) for path in paths]
    expected = np.mean([t.query("method == 'fvs' and k == 5")["psnr"].mean() for t in tables])
    cell = read_csv(numbers).query("method == 'fvs' and k == 5 and metric == 'psnr'")
    assert cell["mean"].item() == pytest.approx(expected, abs=1e-6)
    text = table.read_text()
    for method in METHODS.values():
        assert f"\n{method.label} & " in text
    # a rule between the paper's baselines, the further ones, and the references
    assert text.count(r"\midrule") == 3
    assert "search" not in text


def test_the_caption_names_what_made_the_table():
    text = caption(FACTS | SEARCHED | {"real": ["fox"], "searched": True}, METRICS)
    captures = (r"Tanks \& Temples", "stand-ins", "fox")
    for part in (*captures, r"lab\_hog", "GMSD", r"R \& D alone", "1 of 3 target"):
        assert part in text
