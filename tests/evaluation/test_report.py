"""Summaries, the LaTeX table and the heatmap: hand-worked values and slow twins."""

import re
from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fsel.evaluation.latex import number, sweep_table, tex
from fsel.evaluation.summary import (
    ALL_FRAMES,
    differences,
    draw_means,
    summarise,
    with_all_datasets,
)
from fsel.stages.heatmap import draw, gains

METRICS = ("psnr", "ssim")


def cells(values: dict) -> pd.DataFrame:
    """(dataset, scene, draw, method, k) -> psnr; ssim is a hundredth of it."""
    rows = [(*key, value, value / 100) for key, value in values.items()]
    return pd.DataFrame(rows, columns=["dataset", "scene", "draw", "method", "k", *METRICS])


def grid(seed: int = 0, scenes: int = 3, draws: int = 2) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    rows = product(range(scenes), range(draws), ("random", "less_is_more"), (10, 20))
    return cells({("d", f"s{s}", d, method, k): rng.normal(20, 2) for s, d, method, k in rows})


def test_targets_are_averaged_within_a_seed_first():
    rows = [("random", 0, 10, 1.0), ("random", 0, 10, 3.0), ("random", 1, 10, 10.0)]
    rows.append(("all", 0, 145, 20.0))
    evaluation = pd.DataFrame(rows, columns=["method", "seed", "k", "psnr"])
    table = draw_means(evaluation, ["psnr"]).to_numpy().tolist()
    assert table == [["all", ALL_FRAMES, 20.0], ["random", 10, 6.0]]


@pytest.mark.parametrize(
    ("lost", "said"),
    [
        ({"draw": 1}, r"unequal sets.*'s0': 1, 's1': 2"),
        ({"method": "less_is_more"}, r"d: a mean over unequal sets.*2 of 3 scenes"),
    ],
)
def test_means_over_unequal_sets_are_refused(lost, said):
    table, gone = grid(), {"scene": "s0", **lost}
    rest = table[(table[list(gone)] != list(gone.values())).any(axis=1)]
    with pytest.raises(ValueError, match=said):
        summarise(rest, METRICS)


def test_summary_mean_interval_and_count():
    table = summarise(grid(), METRICS)
    source = grid().query("method == 'less_is_more' and k == 20")["psnr"]
    row = table.query("method == 'less_is_more' and k == 20 and metric == 'psnr'").iloc[0]
    assert row["mean"] == pytest.approx(source.mean())
    means = grid().query("method == 'less_is_more' and k == 20").groupby("scene")["psnr"].mean()
    wanted = stats.ttest_1samp(means, 0).confidence_interval(0.95)
    np.testing.assert_allclose(row[["ci_low", "ci_high"]].astype(float), wanted)
    assert row["n"] == 3
    assert list(table["method"].unique()) == ["random", "less_is_more"]


def test_scenes_of_one_place_are_one_place():
    table = grid(scenes=4).assign(place=lambda t: t["scene"].map({"s0": "a", "s1": "a"}))
    table["place"] = table["place"].fillna(table["scene"])
    row = summarise(table, ["psnr"]).query("method == 'less_is_more' and k == 10").iloc[0]
    own = table.query("method == 'less_is_more' and k == 10")
    scenes = own.groupby(["place", "scene"])["psnr"].mean()
    assert row["n"] == 3
    assert row["mean"] == pytest.approx(scenes.groupby("place").mean().mean())


def test_training_seeds_move_the_interval_and_not_the_mean():
    seeds = {0: -1.0, 1: 0.0, 2: 1.0}
    one = grid(scenes=6)
    table = pd.concat([one.assign(seed=s, psnr=one["psnr"] + up) for s, up in seeds.items()])
    apart, alike = summarise(table, ["psnr"], trained=["less_is_more"]), summarise(table, ["psnr"])
    np.testing.assert_allclose(apart["mean"], alike["mean"])
    wider = (apart["ci_high"] - apart["ci_low"]) / (alike["ci_high"] - alike["ci_low"])
    assert (wider[apart["method"] == "less_is_more"] > 1.2).all()
    np.testing.assert_allclose(wider[apart["method"] == "random"], 1)


def test_all_datasets_are_one_more():
    two = pd.concat([grid(0), grid(1).assign(dataset="e")], ignore_index=True)
    table = summarise(with_all_datasets(two), ["psnr"]).set_index(["dataset", "method", "k"])
    assert table.loc[("all", "less_is_more", 10), "n"] == 6
    halves = table.loc[[("d", "less_is_more", 10), ("e", "less_is_more", 10)], "mean"]
    assert table.loc[("all", "less_is_more", 10), "mean"] == pytest.approx(halves.mean())
    lacking = two[(two["dataset"] == "d") | (two["method"] == "less_is_more")]
    assert "random" not in with_all_datasets(lacking).query("dataset == 'all'")["method"].to_numpy()
    assert len(with_all_datasets(grid())) == len(grid())


def test_a_method_of_fewer_draws_is_summarised_over_those():
    table = grid()
    table = table[(table["method"] != "less_is_more") | (table["draw"] == 0)]
    summary = summarise(table, ["psnr"])
    row = summary.query("method == 'less_is_more' and k == 10").iloc[0]
    kept = table.query("method == 'less_is_more' and k == 10")["psnr"]
    assert row["mean"] == pytest.approx(kept.mean())
    assert row["n"] == 3


def test_paired_differences_are_narrower_than_their_parts():
    values, rng = {}, np.random.default_rng(0)
    for s in range(10):
        hard = rng.normal(0, 5)
        values["d", f"s{s}", 0, "random", 10] = 20 + hard
        values["d", f"s{s}", 0, "less_is_more", 10] = 21 + hard
    table = differences(cells(values), ["less_is_more"], ["psnr"])
    row = table.iloc[0]
    assert row[["method", "reference", "k", "n"]].tolist() == ["less_is_more", "random", 10, 10]
    np.testing.assert_allclose(row[["mean", "ci_low", "ci_high"]].astype(float), 1)


def test_every_budget_is_compared_with_all_frames():
    values = {("d", "s", 0, "less_is_more", k): 20.0 + k for k in (10, 20)}
    values["d", "s", 0, "all", ALL_FRAMES] = 25.0
    table = differences(cells(values), ["less_is_more"], ["psnr"])
    found = table[["reference", "k", "mean"]].to_numpy().tolist()
    assert found == [["all", 10, 5.0], ["all", 20, 15.0]]


@pytest.mark.parametrize(
    ("value", "metric", "text"),
    [
        (20.004, "psnr", "20.00"),
        (0.9, "psnr", "0.90"),
        (0.6994, "ssim", ".699"),
        (1, "ssim", "1.000"),
    ],
)
def test_numbers(value, metric, text):
    assert number(value, metric) == text


def test_special_characters_are_escaped():
    assert tex("Tanks & Temples_2 (100%)") == r"Tanks \& Temples\_2 (100\%)"


def table_of(summary: pd.DataFrame, datasets: dict) -> str:
    groups = [{"random": "Random", "less_is_more": "Ours"}, {"all": "All frames"}]
    shown = {"datasets": datasets, "groups": groups, "ranked": list(groups[0])}
    numbers = {"budgets": [10, 20], "higher_is_better": {"psnr": True, "ssim": True}}
    return sweep_table(summary, **shown, **numbers, caption="Text.", label="tab:x")


def test_table_cells_bold_and_counts():
    values = {
        ("d", "s", 0, "random", 10): 20.0,
        ("d", "s", 0, "less_is_more", 10): 21.0,
        ("d", "s", 0, "less_is_more", 20): 22.0,
        ("d", "s", 0, "all", ALL_FRAMES): 30.0,
    }
    text = table_of(summarise(cells(values), METRICS), {"d": "D"})
    assert r"Random & 20.00/.200 & -- \\" in text
    assert r"Ours & \textbf{21.00}/\textbf{.210} & \textbf{22.00}/\textbf{.220} \\" in text
    assert r"All frames & \multicolumn{2}{c}{30.00/.300} \\" in text
    assert r"\multicolumn{2}{c}{\textbf{D} ($n{=}1$)}" in text


def test_equal_prints_share_the_lead():
    values = {("d", "s", 0, "random", 10): 20.001, ("d", "s", 0, "less_is_more", 10): 20.002}
    text = table_of(summarise(cells(values), METRICS), {"d": "D"})
    assert text.count(r"\textbf{20.00}") == 2


def test_blocks_have_two_datasets_and_a_page_three_blocks():
    names = "abcdefg"
    values = {(d, "s", 0, "random", k): 20.0 for d in names for k in (10, 20)}
    text = table_of(summarise(cells(values), METRICS), {name: name.upper() for name in names})
    forms = re.findall(r"\\begin\{tabular\}\{(.*?)\}", text)
    assert forms == ["lcc|cc"] * 3 + ["lcc"]
    rows = [line.count("&") for line in text.splitlines() if line.startswith("Random")]
    assert rows == [4, 4, 4, 2]
    assert (text.count(r"\midrule"), text.count("Ours"), text.count("All frames")) == (4, 0, 0)
    first, second = text.split(r"\begin{table*}")[1:]
    assert (first.count(r"\toprule"), second.count(r"\toprule")) == (3, 1)
    assert (text.count(r"\label{"), text.count("continued")) == (1, 1)
    assert text.count(r"\begin{") == text.count(r"\end{")


def panel() -> pd.DataFrame:
    method = "less_is_more"
    means = {10: {"random": 20.0, "nearest": 21.0, method: 21.5}}
    means[20] = {"random": 24.0, "nearest": 23.0, method: 24.0}
    values = {
        ("d", f"s{s}", 0, name, k): mean + s + (k == 20 and name == method) * (-1) ** s
        for s in range(6)
        for k, own in means.items()
        for name, mean in own.items()
    }
    table = cells(values)
    parts = summarise(table, METRICS), differences(table, [method], METRICS)
    asked = {"baselines": ["random", "nearest"], "datasets": ["d"], "budgets": [10, 20]}
    return gains(*parts, method=method, **asked)


def test_gain_is_over_the_strongest_baseline_of_each_cell():
    table = panel()
    assert table["reference"].tolist() == ["nearest", "random"]
    np.testing.assert_allclose(table["gain"], [0.5, 0.0])
    assert table["significant"].tolist() == [True, False]


def test_figures_of_equal_numbers_are_equal_bytes(tmp_path):
    facts = {"embedded": ["A"], "real": [], "reconstructor": "splats", "long_side": 32}
    for name in "ab":
        outputs = [tmp_path / f"{name}.pdf", tmp_path / f"{name}.png"]
        draw({"a": panel(), "b": panel()}, {"d": "Dataset"}, outputs, facts)
    for form in ("pdf", "png"):
        first, second = ((tmp_path / f"{name}.{form}").read_bytes() for name in "ab")
        assert first == second
        assert len(first) > 1000
