"""Labels by another reconstructor: what is compared with what."""

import numpy as np
import pandas as pd
import pytest

from fsel.experiments.label_judge import agreement, label_judge

FACTS = {"embedded": ["DL3DV"], "real": []}
LABELLERS = {
    "splats": {"reconstructor": "splats", "long_side": 48},
    "g_2": {"reconstructor": "g_2 (gaussians)", "long_side": 96},
}
JUDGES = {"splats": LABELLERS["splats"], "far": {"reconstructor": "gaussians", "long_side": 96}}
PROBLEMS = ["d/a/draw0", "e/a/draw0"]


def labels(path, fitness, generations=None):
    subsets = [[1, 2], [1, 3], [2, 3], [2, 4]][: len(fitness)]
    found = pd.DataFrame({"subset": subsets, "fitness": fitness})
    found["generation"] = 0 if generations is None else generations
    found.to_parquet(path)
    return path


def evaluations(folder, gains):
    """Two seeds and targets; the first labeller has 20 and 24 dB on the two problems."""
    paths = []
    for judge in JUDGES:
        for labeller in LABELLERS:
            for problem, base in zip(PROBLEMS, (20.0, 24.0), strict=True):
                gain = gains[judge][problem] if labeller != "splats" else 0.0
                rows = [
                    {"method": "ours", "seed": seed, "k": 20, "target": t, "psnr": base + gain + t}
                    for seed in (0, 1)
                    for t in (-1, 1)
                ]
                paths.append(folder / f"{judge}{labeller}{problem.replace('/', '')}.parquet")
                pd.DataFrame(rows).to_parquet(paths[-1])
    return paths


def test_each_labeller_is_compared_with_the_first_under_each_judge(tmp_path):
    gains = {
        "splats": dict(zip(PROBLEMS, (-1.0, -1.0), strict=True)),
        "far": dict(zip(PROBLEMS, (1.0, 3.0), strict=True)),
    }
    own = labels(tmp_path / "own.parquet", [0.1, 0.5, 0.9])
    other = labels(tmp_path / "other.parquet", [0.8, 0.5, 0.1])
    table, numbers = tmp_path / "t.tex", tmp_path / "t.csv"
    label_judge(
        evaluations(tmp_path, gains),
        [own, other],
        table,
        numbers,
        problems=PROBLEMS,
        labellers=LABELLERS,
        judges=JUDGES,
        labelled=1,
        budgets=[20],
        facts=FACTS,
    )
    text = table.read_text()
    assert r"\texttt{splats} &  & 22.00 & 22.00" in text
    assert r"21.00 ($\mathbf{-1.00}$ {\tiny$[-1.00,-1.00]$})" in text
    # 1 and 3 dB: 2 plus and minus 12.71 standard errors of 1
    assert r"24.00 ($+2.00$ {\tiny$[-10.71,+14.71]$})" in text
    assert r"\texttt{g\_2} & -1.00 &" in text
    assert "over 2 scenes (2 draws of targets)" in text
    found = pd.read_csv(numbers, keep_default_na=False)
    row = found[(found["judge"] == "far") & (found["reference"] == "splats")].iloc[0]
    assert (row["labels"], row["k"], float(row["mean"])) == ("g_2", "20", 2.0)
    assert found[found["metric"] == "spearman"]["mean"].astype(float).tolist() == [-1.0]


def test_agreement_is_of_the_subsets_that_both_searches_begin_with(tmp_path):
    own = labels(tmp_path / "a.parquet", [0.1, 0.2, 0.3, 0.0], [0, 0, 0, 1])
    same = labels(tmp_path / "b.parquet", [0.5, 0.6, 0.9, 1.0], [0, 0, 0, 1])
    half = labels(tmp_path / "c.parquet", [0.2, 0.1, 0.3])
    assert agreement([own], [same]) == 1
    assert agreement([own, own], [same, half]) == pytest.approx((1 + 0.5) / 2)
    flat = labels(tmp_path / "d.parquet", [1.0, 1.0, 1.0])
    assert np.isnan(agreement([own], [flat]))
