"""The tables of tested features and scorers: their rows, a whole run, and numbers by hand."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from described_scene import filmed
from evaluation_files import FACTS

from fsel.core.split import Split, coverage_split
from fsel.evaluation.evaluator import Evaluator
from fsel.experiments.paper.ablation.architectures import MODULES
from fsel.experiments.paper.ablation.extras import EXTRAS
from fsel.experiments.paper.ablation.tables import (
    SYMBOLS,
    compare_trials,
    feature_sweep,
    scorer_arch,
)
from fsel.experiments.paper.ablation.trials import TRIALS, trial_case
from fsel.experiments.scheme import cells_of
from fsel.features.columns import FEATURES
from fsel.metrics import METRICS
from fsel.reconstruct import reconstructor_of
from fsel.stages.features import features
from fsel.stages.order import order
from fsel.stages.split import split

ROOT = Path(__file__).resolve().parents[4]
SCORERS = yaml.safe_load((ROOT / "config" / "scorers.yaml").read_text())
SCENES = [("d", "a"), ("d", "b")]
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}


def configurations() -> list[dict]:
    with (ROOT / "config" / "feature_sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_the_configurations_are_43_and_differ():
    rows = configurations()
    assert list(rows[0]) == ["number", *FEATURES, "added"]
    assert [row["number"] for row in rows] == [str(i) for i in range(1, 44)]
    assert {mark for row in rows for name, mark in row.items() if name in FEATURES} == {"", "1"}
    contents = {tuple(value for key, value in row.items() if key != "number") for row in rows}
    assert len(contents) == 43
    assert all(rows[0][name] for name in FEATURES)
    assert list(SYMBOLS) == list(FEATURES)
    groups = [row["added"] for row in rows if row["added"]]
    assert sorted(groups) == sorted(EXTRAS)
    for row in rows:  # a group never hides a feature that is shown
        if row["added"] and row["added"] != "rank_normalised":
            assert not any(row[name] for name in EXTRAS[row["added"]].replaces)


def test_the_scorers_are_the_papers_17():
    assert len(SCORERS) == len({scorer["label"] for scorer in SCORERS.values()}) == 17
    built = {(s["module"], *sorted(s["settings"].items())) for s in SCORERS.values()}
    assert len(built) == 17
    assert {scorer["module"] for scorer in SCORERS.values()} == set(MODULES)


def test_what_the_lists_may_hold_is_what_the_library_has():
    schema = yaml.safe_load((ROOT / "workflow" / "schemas" / "cases.schema.yaml").read_text())
    lists = schema["properties"]
    scorer, row = (lists[name] for name in ("scorers", "configurations"))
    modules = scorer["additionalProperties"]["properties"]["module"]["enum"]
    assert sorted(modules) == sorted(MODULES)
    assert row["items"]["required"] == ["number", *FEATURES, "added"]
    assert row["items"]["properties"]["added"]["enum"] == ["", *EXTRAS]


@pytest.fixture(scope="module")
def labelled(tmp_path_factory):
    """A capture with two coverage levels' labels, drawn at random, and two draws of targets."""
    folder = tmp_path_factory.mktemp("trials")
    capture = filmed()
    capture.save(folder)
    rng = np.random.default_rng(0)
    described = rng.normal(size=(len(capture), 8))
    described /= np.linalg.norm(described, axis=1, keepdims=True)
    table = {"descriptor": described.tolist(), "sharpness": rng.uniform(1, 9, len(capture))}
    pd.DataFrame(table).to_parquet(folder / "descriptors.parquet")
    parts, labels = [], {}
    for coverage in (25, 40):
        drawn = coverage_split(capture, coverage, 0)
        subsets = [rng.choice(drawn.candidates, 5, replace=False).tolist() for _ in range(2)]
        labels[coverage] = folder / f"p{coverage}.parquet"
        pd.DataFrame({"subset": subsets, "fitness": [0.6, 0.5], "rank": [0, 1]}).to_parquet(
            labels[coverage]
        )
        parts.append(pd.DataFrame(drawn.table(capture.names)).assign(coverage=coverage))
    pd.concat(parts).to_parquet(folder / "splits.parquet")
    features(folder, [folder / "splits.parquet"], [folder / "features.parquet"], config="x")
    read = [[folder / "splits.parquet"], [folder / "features.parquet"], labels.values()]
    roles = {"scenes": {"s": "train"}, "coverages": {"s": list(labels)}}
    order([folder], *read, folder / "trajectories.parquet", **roles, kept=2, config="x")
    splits = [folder / f"draw{n}.parquet" for n in range(2)]
    split(folder, splits, targets=5, seed=1, config="x")
    return capture, folder, splits


def tried(labelled, output, seeds=2, k=4, **case):
    _, folder, splits = labelled
    settings = {"module": "perceptron", "settings": {"width": 64}, "shown": FEATURES, "added": None}
    labels = [folder], [folder / "splits.parquet"], folder / "trajectories.parquet"
    asked = {"trial": output.stem, "case": settings | case, "scenes": ["s"], "k": k}
    asked["problems"] = [f"d/v/draw{n}" for n in range(len(splits))]
    training = {"seeds": seeds, "epochs": 1, "learning_rate": 1e-3}
    trial_case(*labels, [folder], splits, output, **asked, **training, config="x")
    return pd.read_parquet(output)


CASES = {
    "three features": {"shown": ["d_min_o", "d_min_s", "sharpness"]},
    **{name: {"added": name} for name in EXTRAS},
    **{
        name: {"module": scorer["module"], "settings": scorer["settings"]}
        for name, scorer in SCORERS.items()
        if name in ("pooled", "cross_attention", "bilstm", "lstm_decoder", "view_attention")
    },
}


@pytest.mark.parametrize("case", CASES)
def test_every_kind_of_case_picks_candidates(labelled, tmp_path, case):
    table = tried(labelled, tmp_path / "t.parquet", seeds=1, **CASES[case])
    assert table["draw"].tolist() == [0] * 4 + [1] * 4
    for (_, picks), path in zip(table.groupby("draw")["frame"], labelled[2], strict=True):
        assert len(set(picks)) == 4
        assert np.isin(picks, Split.load(path).candidates).all()
    assert np.isfinite(table["loss"]).all()
    assert table["agreement"].between(0, 1).all()


def test_picks_are_measured_on_their_own_draws_targets(labelled, tmp_path):
    capture, folder, splits = labelled
    paths = {}
    for name in ("a", "b"):
        paths[name] = tmp_path / f"{name}.parquet"
        tried(labelled, paths[name], seeds=1)
    output = tmp_path / "measured.parquet"
    how = {"settings": {"dataset": "d", "scene": "v"}, "reconstruction": RECONSTRUCTION}
    how |= {"splits": splits, "metrics": METRICS, "config": "x"}
    TRIALS.evaluate([folder], [*paths.values()], output, **how)
    table = pd.read_parquet(output)
    assert table["k"].unique().tolist() == [4]
    found = table.groupby(["method", "draw"])[list(METRICS)].mean()
    assert len(found) == 4
    reconstructor = reconstructor_of(capture, RECONSTRUCTION)
    for draw, path in enumerate(splits):
        picks = pd.read_parquet(paths["a"]).query("draw == @draw")["frame"].to_numpy()
        evaluate = Evaluator.on_frames(reconstructor, Split.load(path).targets)
        measured = found.loc[("a", draw), list(METRICS)].astype(float)
        np.testing.assert_allclose(measured, evaluate(picks))
        assert found.loc[("b", draw), "psnr"] == found.loc[("a", draw), "psnr"]


def results(folder, psnr: dict) -> tuple[list, dict]:
    """name -> PSNR by (scene, draw, seed), as files of a run."""
    measured, trials = [], {}
    for scene in ("a", "b"):
        rows = [
            (name, seed, draw, 20, value + sign, 0.5, 0.1)
            for name, values in psnr.items()
            for (where, draw, seed), value in values.items()
            if where == scene
            for sign in (-1, 1)  # two targets
        ]
        columns = ["method", "seed", "draw", "k", *METRICS]
        path = folder / f"{scene}.parquet"
        pd.DataFrame(rows, columns=columns).to_parquet(path)
        measured.append(path)
    for i, name in enumerate(psnr):
        trials[name] = folder / f"trial-{name}.parquet"
        rows = {"seed": [0, 1], "parameters": [1000 + i] * 2, "loss": [4.0, 5.0]}
        pd.DataFrame(rows).assign(agreement=[0.1, 0.2]).to_parquet(trials[name])
    return measured, trials


KEYS = [(scene, draw, seed) for scene in "ab" for draw in (0, 1) for seed in (0, 1)]


def shifted(*shifts):
    """20 dB, and as many dB more on each scene and draw; seeds straddle it."""
    by_problem = dict(zip([("a", 0), ("a", 1), ("b", 0), ("b", 1)], shifts, strict=True))
    return {
        (scene, draw, seed): 20.0 + by_problem[scene, draw] + (0.3 if seed else -0.3)
        for scene, draw, seed in KEYS
    }


def written(folder, psnr, measured, trials) -> str:
    labels = {name: SCORERS[name]["label"] for name in psnr}
    paths = folder / "t.tex", folder / "t.csv"
    settings = {"scenes": SCENES, "labels": labels, "facts": FACTS | {"epochs": 4}}
    scorer_arch(measured, [*trials.values()], *paths, **settings)
    return paths[0].read_text()


def test_differences_to_the_reference_by_hand(tmp_path):
    psnr = {
        "wider": shifted(1.0, 1.0, 1.0, 1.0),
        "less_is_more": shifted(0, 0, 0, 0),
        "rnn": shifted(-1.0, 0.0, 1.0, 2.0),
    }
    measured, trials = results(tmp_path, psnr)
    table = compare_trials(cells_of(SCENES, measured, ["psnr"], FACTS), trials, "less_is_more")
    table = table.set_index("method")
    assert list(table.index) == ["wider", "less_is_more", "rnn"]
    np.testing.assert_allclose(table["mean"], [21.0, 20.0, 20.5])
    np.testing.assert_allclose(table["difference"], [1.0, np.nan, 0.5])
    assert table.loc["wider", "difference_low"] == pytest.approx(1.0)
    assert table.loc["rnn", "difference_low"] < 0 < table.loc["rnn", "difference_high"]
    assert table["parameters"].tolist() == [1000, 1001, 1002]
    assert table.loc["less_is_more", ["loss", "seeds", "draws", "n"]].tolist() == [4.5, 2, 2, 2]
    text = written(tmp_path, psnr, measured, trials)
    assert r"Wider MLP (256 units) & 1,000 & $\mathbf{+1.00}$ {\tiny$[+1.00,+1.00]$}" in text
    assert r"3-layer MLP (ours) & 1,001 & $0$ \\" in text
    assert r"RNN-based sequential scorer & 1,002 & $+0.50$" in text
    for part in ("$K{=}20$ on 2 validation scenes", "2 target draws", "2 training seeds", "4 pass"):
        assert part in text
    assert "zero ($1$ of $2$)" in text
    assert pd.read_csv(tmp_path / "t.csv")["difference"].tolist()[::2] == [1.0, 0.5]


def test_a_trial_that_did_not_finish_is_not_the_reference(tmp_path):
    psnr = {"less_is_more": shifted(0, 0, 0, 0), "rnn": shifted(1, 1, 1, 1)}
    measured, trials = results(tmp_path, psnr)
    table = pd.read_parquet(measured[0]).assign(outcome="")
    table.loc[table["method"] == "rnn", ["psnr", "outcome"]] = np.nan, "timeout"
    table.to_parquet(measured[0])
    text = written(tmp_path, psnr, measured, trials)
    assert r"3-layer MLP (ours) & 1,000 & $0$ \\" in text
    assert r"RNN-based sequential scorer & 1,001 &  \\" in text
    assert "$20.00$" in text


def test_the_table_of_features_marks_what_is_shown(tmp_path):
    rows = {row["number"]: row for row in configurations() if row["number"] in ("1", "6", "37")}
    cases = {
        number: {"shown": [f for f in FEATURES if row[f]], "added": row["added"] or None}
        for number, row in rows.items()
    }
    psnr = {"1": shifted(0, 0, 0, 0), "6": shifted(0, 0, 0, 0), "37": shifted(-1, -1, -1, -1)}
    measured, trials = results(tmp_path, psnr)
    paths = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"scenes": SCENES, "cases": cases, "facts": FACTS | {"epochs": 4}}
    feature_sweep(measured, [*trials.values()], *paths, **settings)
    lines = paths[0].read_text().splitlines()
    marked = {line.split(" & ")[0]: line for line in lines if r"\bullet" in line}
    counts = {name: line.count("bullet") for name, line in marked.items()}
    assert counts == {"1": 18, "6": 13, "37": 1}
    assert all(line.count("&") == 20 for line in marked.values())
    assert "& rank-normalized & $+0.00$" in marked["6"]
    assert r"&  & $\mathbf{-1.00}$" in marked["37"]
