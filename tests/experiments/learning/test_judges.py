"""A second judge of labelled subsets and of networks' picks: who is judged, and what is told."""

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene
from small_sweep import RECONSTRUCTION

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.experiments.learning.judges_rank import judges_rank, measures, over_scenes
from fsel.experiments.learning.judging import judge_requests, spread
from fsel.experiments.learning.picking import evaluate_learned
from fsel.reconstruct import reconstructor_of
from fsel.split import coverage_split

FACTS = {"embedded": ["X"], "real": []}
JUDGES = {
    "labeller": {"reconstructor": "splats", "long_side": 64},
    "judge": {"reconstructor": "g_2", "long_side": 96},
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture."""
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def asked(scene, tmp_path_factory):
    """Two requests with eight labels each, by `splats`, and their splits."""
    folder, rng = tmp_path_factory.mktemp("asked"), np.random.default_rng(0)
    capture = Capture.load(scene)
    reconstructor = reconstructor_of(capture, RECONSTRUCTION)
    tables, parts = [], []
    for number in (0, 1):
        split = coverage_split(capture, 25, number)
        evaluator = Evaluator.on_frames(reconstructor, split.targets, metrics=("psnr",))
        pool = np.setdiff1d(np.arange(40), split.targets)
        subsets = [np.sort(rng.choice(pool, 4, replace=False)).tolist() for _ in range(8)]
        part = pd.DataFrame({"subset": subsets, "start": ["fsel"] * 7 + ["nearest"]})
        part["psnr"] = [float(evaluator(np.array(subset))[0]) for subset in subsets]
        part["rank"] = (-part["psnr"]).rank().astype(int) - 1
        tables.append(part.assign(request=number, k=4))
        parts.append(split.table(capture.names).assign(request=number))
    paths = folder / "requests.parquet", folder / "splits.parquet"
    pd.concat(tables).to_parquet(paths[0])
    pd.concat(parts).to_parquet(paths[1])
    return paths


def test_the_judge_that_labelled_says_the_same_again(scene, asked, tmp_path):
    settings = {"reconstruction": RECONSTRUCTION, "subsets": 5, "config": "c"}
    judge_requests(scene, *asked, tmp_path / "judged.parquet", **settings)
    found = pd.read_parquet(tmp_path / "judged.parquet")
    np.testing.assert_allclose(found["psnr_again"], found["psnr"], atol=1e-6)
    labels = pd.read_parquet(asked[0])
    for number, part in found.groupby("request"):
        own = labels[labels["request"] == number].set_index("rank")
        assert len(part) <= 5
        assert part["rank"].is_monotonic_increasing
        assert {0, 7} <= set(part["rank"])
        np.testing.assert_array_equal(own.loc[part["rank"], "psnr"], part["psnr"])
        first = labels[labels["request"] == number].iloc[[0, 7]]
        assert set(part[part["begun"]]["rank"]) == set(first["rank"])
    assert measures(found.assign(scene="s"))["spearman"].tolist() == [1.0, 1.0]


def test_a_sample_has_the_starts_and_ranks_from_the_best_to_the_worst():
    rank = [5, 9, 0, 7, 8, 3, 1, 2, 10, 4, 6]
    start = ["fsel"] * 3 + ["nearest"] * 4 + ["exchanged"] * 4
    part = pd.DataFrame({"rank": rank, "start": start})
    # starts are 5, 7 and 2; three others are 0, 5 and 10
    found = spread(part, 6)
    assert found["rank"].tolist() == [0, 2, 5, 7, 10]
    assert found["begun"].tolist() == [False, True, True, True, False]
    # six others: 0, 2, 4, 6, 8 and 10
    assert spread(part, 9)["rank"].tolist() == [0, 2, 4, 5, 6, 7, 8, 10]
    assert spread(part, 99)["rank"].tolist() == list(range(11))


def request(number, label, again, k=10, scene="a", rule=1):
    rows = pd.DataFrame({"psnr": label, "psnr_again": again})
    rows["start"], rows["begun"] = "fsel", np.arange(len(rows)) == rule
    rows.loc[len(rows) - 1, ["start", "begun"]] = "nearest", True
    return rows.assign(request=number, k=k, scene=scene)


def test_what_is_told_of_a_request_by_hand():
    label = [25.0, 24.0, 23.0, 21.0]
    found = measures(request(0, label, [28.0, 27.0, 30.0, 25.0])).iloc[0]
    # ranks 4 3 2 1 and 3 2 4 1: 1 - 6 * (1 + 1 + 4 + 0) / (4 * 15)
    assert found["spearman"] == pytest.approx(0.4)
    assert found["lost"] == 30 - 28
    assert found["lost_random"] == 30 - 27.5
    assert (found["gain"], found["gain_again"]) == (1, 1)
    found = measures(request(0, label, [28.0, 29.0, 20.0, 30.0], rule=2)).iloc[0]
    assert (found["gain"], found["gain_again"]) == (2, 8)
    flat = measures(request(0, label, [28.0] * 4)).iloc[0]
    assert np.isnan(flat["spearman"])
    assert flat["lost"] == flat["lost_random"] == 0


def test_means_are_over_requests_then_over_scenes():
    found = measures(
        pd.concat(
            [
                request(0, [3.0, 2, 1], [6.0, 5, 4], k=10, scene="a"),
                request(1, [3.0, 2, 1], [4.0, 5, 6], k=10, scene="a"),
                request(2, [3.0, 2, 1], [4.0, 5, 6], k=20, scene="a"),
                request(0, [3.0, 2, 1], [6.0, 5, 4], k=10, scene="b"),
            ]
        )
    )
    result = over_scenes(found).set_index(["k", "metric"])
    own = result.loc[(10, "spearman")]
    # 0 and 1: a half plus and minus 12.71 standard errors of a half
    assert (own["mean"], own["n"], own["requests"]) == (0.5, 2, 3)
    assert own["ci_high"] == pytest.approx(0.5 + 12.706 / 2, abs=1e-3)
    assert result.loc[(20, "lost"), "mean"] == 2
    assert np.isnan(result.loc[(20, "lost"), "ci_low"])
    # scene a has lost 0, 2 and 2 dB, scene b none
    assert result.loc[("", "lost"), "mean"] == pytest.approx(2 / 3)
    assert result.loc[("", "lost_random"), "mean"] == 1


def test_the_table_has_a_row_a_budget_and_one_for_all(tmp_path):
    files = []
    for at, again in enumerate(([6.0, 5, 4], [4.0, 5, 6])):
        rows = request(0, [3.0, 2, 1], again).drop(columns="scene")
        files.append(tmp_path / f"{at}.parquet")
        rows.to_parquet(files[-1])
    table, numbers = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"scenes": ["d/a", "e/a"], "facts": FACTS} | JUDGES
    judges_rank(files, table, numbers, **settings)
    text = table.read_text()
    row = r"10 & 2 & 2 & $0.00$ {\tiny$[-12.71,12.71]$} & $1.00$ {\tiny$[-11.71,13.71]$} & "
    row += r"$1.00$ {\tiny$[1.00,1.00]$} & "
    row += r"$\mathbf{+1.00}$ {\tiny$[+1.00,+1.00]$} & $+0.00$ {\tiny$[-12.71,+12.71]$} \\"
    assert row in text
    assert row.replace("10 &", "all &", 1) in text
    assert r"\texttt{splats} at 64 pixels; 3 subsets of each" in text
    assert r"\texttt{g\_2} at 96 pixels" in text
    found = pd.read_csv(numbers)
    assert found["judge"].unique().tolist() == ["g_2"]
    assert found["k"].isna().sum() == 5
    assert found.query("metric == 'lost'")["mean"].tolist() == [1.0, 1.0]


def test_picks_of_other_budgets_and_draws_are_left_out(scene, tmp_path):
    capture = Capture.load(scene)
    split = coverage_split(capture, 25, 0)
    split.table(capture.names).to_parquet(tmp_path / "split.parquet")
    frames = np.setdiff1d(np.arange(40), split.targets)
    rows = [
        {"draw": draw, "method": "m", "seed": 0, "k": k, "frame": frame}
        for draw in (0, 1)
        for k in (3, 5)
        for frame in frames[:k]
    ]
    pd.DataFrame(rows).to_parquet(tmp_path / "picks.parquet")
    settings = {"reconstruction": RECONSTRUCTION, "budgets": [5], "config": "c"}
    paths = [tmp_path / f"{name}.parquet" for name in ("split", "picks", "evaluation")]
    evaluate_learned(scene, paths[:1], *paths[1:], **settings)
    found = pd.read_parquet(paths[2])
    assert found[["draw", "k"]].drop_duplicates().to_numpy().tolist() == [[0, 5]]
    assert sorted(found["target"]) == sorted(split.targets)
