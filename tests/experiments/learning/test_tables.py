"""Tables of ways to learn and of sets of inputs, by hand."""

import numpy as np
import pandas as pd

from fsel.experiments.learning.cases import INPUT_CASES
from fsel.experiments.learning.tables import inputs as inputs_table
from fsel.experiments.learning.tables import learning
from fsel.report.numbers import read_csv


def evaluation(path, gains):
    rows = [
        {"draw": d, "method": name, "seed": seed, "k": k, "target": t, "psnr": 20.0 + k + gain}
        for d in (0, 1)
        for name, by_seed in gains.items()
        for seed, gain in enumerate(by_seed)
        for k in (10, 20)
        for t in (0, 1)
    ]
    pd.DataFrame(rows).to_parquet(path)
    return path


def test_learners_are_compared_with_the_rule_on_each_role(tmp_path):
    scenes = [("validation", "d", "v"), ("evaluation", "d", "a"), ("evaluation", "e", "a")]
    gains = [[1.0, 1.0], [1.0, 1.0], [2.0, 2.0]]
    files = [
        evaluation(tmp_path / f"{at}.parquet", {"fsel": [0.0], "imitation": own})
        for at, own in enumerate(gains)
    ]
    log = tmp_path / "log.parquet"
    record = {"method": "imitation", "lessons": 90, "seeds": 2, "seconds": 12.4}
    pd.DataFrame([record]).to_parquet(log)
    facts = {"embedded": ["X"], "real": [], "reconstructor": "splats", "long_side": 64}
    facts["descriptor"] = "lab_hog"
    table, numbers = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"scenes": scenes, "learners": ["imitation"], "facts": facts}
    learning(files, [log], table, numbers, **settings)
    text = table.read_text()
    assert r"\textbf{fsel}, the rule &  &  & 35.00 & 35.00" in text
    # 1 and 2 dB: 1.5 plus and minus 12.71 standard errors of a half
    assert r"& 90 & 12 & 36.00 ($+1.00$) & 36.50 ($+1.50$ {\tiny$[-4.85,+7.85]$})" in text
    assert "1 validation, 2 evaluation scenes" in text
    found = read_csv(numbers)
    own = found.query("method == 'imitation' and role == 'evaluation' and reference == 'fsel'")
    assert own["k"].isna().sum() == 1
    np.testing.assert_allclose(own["mean"], 1.5)
    assert (own["lessons"] == 90).all()


def test_inputs_are_compared_with_their_reference_under_each_judge(tmp_path):
    scenes = [("validation", "d", "v"), ("validation", "e", "v")]
    files = {}
    for judge, paper in (("splats", (1.0, 1.0)), ("far", (-1.0, -3.0))):
        for at, gain in enumerate(paper):
            own = {name: [0.0, 0.0] for name in INPUT_CASES} | {"paper": [gain, gain]}
            path = evaluation(tmp_path / f"{judge}{at}.parquet", own)
            files.setdefault(judge, []).append(path)
    for path in files["far"]:
        rows = pd.read_parquet(path)
        rows[(rows["k"] == 20) & (rows["draw"] == 0)].to_parquet(path)
    log = tmp_path / "log.parquet"
    record = {"lessons": 90, "seeds": 2, "seconds": 12.4}
    pd.DataFrame([{"method": name} | record for name in INPUT_CASES]).to_parquet(log)
    facts = {"embedded": ["X"], "real": [], "descriptor": "lab_hog"}
    judges = {
        name: {"reconstructor": name, "long_side": side}
        for name, side in (("splats", 64), ("far", 96))
    }
    table, numbers = tmp_path / "t.tex", tmp_path / "t.csv"
    inputs_table(*files.values(), log, table, numbers, scenes=scenes, judges=judges, facts=facts)
    text = table.read_text()
    assert "what the rule reads & 90 & 12 & 35.00 & 40.00" in text
    # -1 and -3 dB: -2 plus and minus 12.71 standard errors of 1
    row = r"& 36.00 ($\mathbf{+1.00}$ {\tiny$[+1.00,+1.00]$})"
    row += r" & 38.00 ($-2.00$ {\tiny$[-14.71,+10.71]$})"
    assert f"the paper's & 90 & 12 {row}" in text
    assert "$K$ = 10, 20, 2 draws of targets a scene" in text
    assert "$K$ = 20, 1 draw of targets a scene" in text
    assert r"\multicolumn{1}{c}{\texttt{far} at 96 pixels}" in text
    found = read_csv(numbers).query("method == 'paper' and reference == 'rule_reads'")
    assert found.groupby("judge")["mean"].unique().map(list).to_dict() == {
        "far": [-2.0],
        "splats": [1.0],
    }
    assert sorted(found.query("judge == 'far'")["k"].dropna()) == [20]
