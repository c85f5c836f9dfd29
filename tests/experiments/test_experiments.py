"""The paper's other tables: hand-worked values."""

import numpy as np
import pandas as pd
import pytest

from fsel.experiments.ga_vs_learned import compare_with_search, ga_vs_learned
from fsel.experiments.handsign import handsign
from fsel.experiments.seedvar import seedvar
from fsel.metrics import METRICS
from fsel.report.latex import difference
from fsel.report.summary import seed_spread

FACTS = {
    "embedded": ["Tanks & Temples"],
    "real": [],
    "reconstructor": "splats",
    "long_side": 64,
    "descriptor": "lab_hog",
}
BOOTSTRAP = {"resamples": 200, "seed": 0}


def written(folder, values: dict) -> list[dict]:
    """(scene, draw) -> {(method, seed, k): PSNR}, as evaluation files with one target."""
    items = []
    for (scene, draw), runs in values.items():
        rows = [(m, s, k, 0, v, 0.5, 0.1) for (m, s, k), v in runs.items()]
        path = folder / f"{scene}-{draw}-{len(items)}.parquet"
        columns = ["method", "seed", "k", "target", *METRICS]
        pd.DataFrame(rows, columns=columns).to_parquet(path)
        items.append({"dataset": "d", "scene": scene, "draw": draw, "path": path})
    return items


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


def learned_and_not(shift):
    """Three scenes: learned minus untrained is one dB at K = 10, `shift` of the scene at 20."""
    return {
        (f"s{i}", "draw0"): {
            ("ours", 0, 10): 21.0 + i,
            ("untrained", 0, 10): 20.0 + i,
            ("ours", 0, 20): 25.0 + i + shift[i],
            ("untrained", 0, 20): 25.0 + i,
            ("fvs", 0, 10): 30.0,
        }
        for i in range(3)
    }


def test_learned_minus_untrained(tmp_path):
    items = written(tmp_path, learned_and_not([-1.0, 0.0, 0.4]))
    paths = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"datasets": {"d": "A & B"}, "budgets": [10, 20], "bootstrap": BOOTSTRAP}
    handsign(items, *paths, **settings, facts=FACTS)
    numbers = pd.read_csv(paths[1])
    np.testing.assert_allclose(numbers["mean"], [1.0, -0.2])
    assert numbers["reference"].unique().tolist() == ["untrained"]
    text = paths[0].read_text()
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
    runs = {("ours", s, k): 20.0 + s * size for s in range(3) for k, size in ((10, 0.1), (20, 2.0))}
    others = {("fvs", 0, k): 19.0 for k in (10, 20)} | {("nearest", 0, k): 20.5 for k in (10, 20)}
    items = written(tmp_path, {("s", "draw0"): runs | others})
    paths = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"datasets": {"d": "D"}, "budgets": [10, 20], "bootstrap": BOOTSTRAP}
    seedvar(items, *paths, **settings, facts=FACTS)
    numbers = pd.read_csv(paths[1])
    np.testing.assert_allclose(numbers["std"], [0.1, 2.0])
    np.testing.assert_allclose(numbers["margin"], [20.1 - 20.5, 22.0 - 20.5])
    text = paths[0].read_text()
    assert "training seeds ($3$)" in text
    assert "in $1$ of $2$ cells" in text
    assert r"D & 1 & 0.100 & 2.000 \\" in text


def test_one_seed_has_no_spread(tmp_path):
    items = written(tmp_path, {("s", "draw0"): {("ours", 0, 10): 20.0, ("fvs", 0, 10): 19.0}})
    settings = {"datasets": {"d": "D"}, "budgets": [10], "bootstrap": BOOTSTRAP}
    seedvar(items, tmp_path / "t.tex", tmp_path / "t.csv", **settings, facts=FACTS)
    assert r"D & 1 & -- \\" in (tmp_path / "t.tex").read_text()


def searched_cells() -> pd.DataFrame:
    values = {
        "average_random": [18.0, 18.0],
        "average_search": [19.0, 19.5],
        "random_search": [20.0, 20.5],
        "search": [21.0, 22.0],
        "ours": [21.5, 21.5],
        "fsel": [22.0, 23.0],
        "fvs": [1.0, 1.0],
    }
    rows = [("d", f"s{i}", "draw0", m, 20, v) for m, vs in values.items() for i, v in enumerate(vs)]
    # a draw that the search was not run on
    rows.append(("d", "s0", "draw1", "ours", 20, 99.0))
    return pd.DataFrame(rows, columns=["dataset", "scene", "draw", "method", "k", "psnr"])


def test_selectors_against_the_search_by_hand():
    table = compare_with_search(searched_cells(), BOOTSTRAP).set_index("method")
    assert "fvs" not in table.index
    assert table.loc["ours", ["mean", "difference", "ahead", "n"]].tolist() == [21.5, 0.0, 1, 2]
    assert table.loc["fsel", ["mean", "difference", "ahead"]].tolist() == [22.5, 1.0, 2]
    assert table.loc["average_random", "difference"] == -3.5
    assert np.isnan(table.loc["search", "difference"])


def test_average_subsets_are_means_over_what_a_search_met(tmp_path):
    cells = searched_cells().query("draw == 'draw0'")
    kept = cells[~cells["method"].str.startswith("average")]
    values = {}
    for (scene, draw), part in kept.groupby(["scene", "draw"]):
        values[scene, draw] = {(r.method, 0, 20): r.psnr for r in part.itertuples()}
    searched = []
    for scene in ("s0", "s1"):
        rows = [("search", 0, 10.0), ("search", 1, 20.0), ("random_search", 0, 12.0)]
        table = pd.DataFrame(rows, columns=["method", "generation", "psnr"])
        path = tmp_path / f"{scene}.searched"
        table.assign(ssim=0.5, gmsd=0.1).to_parquet(path)
        searched.append({"dataset": "d", "scene": scene, "draw": "draw0", "path": path})
    paths = tmp_path / "t.tex", tmp_path / "t.csv"
    items = written(tmp_path, values)
    ga_vs_learned(items, searched, *paths, k=20, bootstrap=BOOTSTRAP, facts=FACTS)
    means = pd.read_csv(paths[1]).set_index("method")["mean"]
    assert means[["average_search", "average_random"]].tolist() == [15.0, 12.0]
    text = paths[0].read_text()
    assert "reconstruct 2 subsets" in text
    assert "1 of 2" in next(line for line in text.splitlines() if "Ours" in line)
