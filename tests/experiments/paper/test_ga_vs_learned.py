"""The selectors beside the search: hand-worked values."""

import numpy as np
import pandas as pd
from evaluation_files import FACTS, written

from fsel.experiments.paper.ga_vs_learned import (
    SUBSET,
    compare_with_search,
    ga_vs_learned,
    searched_subsets,
)


def searched_cells() -> pd.DataFrame:
    values = {
        "average_random": [18.0, 18.0],
        "average_search": [19.0, 19.5],
        "random_search": [20.0, 20.5],
        "search": [21.0, 22.0],
        "less_is_more": [21.5, 21.5],
        "fsel": [22.0, 23.0],
        "fvs": [1.0, 1.0],
    }
    rows = [("d", f"s{i}", "draw0", m, 20, v) for m, vs in values.items() for i, v in enumerate(vs)]
    # a draw that the search was not run on
    rows.append(("d", "s0", "draw1", "less_is_more", 20, 99.0))
    return pd.DataFrame(rows, columns=["dataset", "scene", "draw", "method", "k", "psnr"])


def test_selectors_against_the_search_by_hand():
    table = compare_with_search(searched_cells()).set_index("method")
    assert "fvs" not in table.index
    ours = table.loc["less_is_more", ["mean", "difference", "ahead", "n"]]
    assert ours.tolist() == [21.5, 0.0, 1, 2]
    assert table.loc["fsel", ["mean", "difference", "ahead"]].tolist() == [22.5, 1.0, 2]
    assert table.loc["average_random", "difference"] == -3.5
    assert np.isnan(table.loc["search", "difference"])


def test_average_subsets_are_means_over_what_a_search_met(tmp_path):
    cells = searched_cells().query("draw == 'draw0'")
    kept = cells[~cells["method"].str.startswith("average")]
    kept = kept[~kept["method"].str.contains("search")]
    values = {
        place: {(r.method, 0, 20): r.psnr for r in part.itertuples()}
        for place, part in kept.groupby(["scene", "draw"])
    }
    searched = []
    for scene in ("s0", "s1"):
        # of two targets each; the second subset is the fittest of the genetic search
        rows = [("search", 0, 1, 9.0), ("search", 0, 1, 11.0), ("search", 1, 0, 20.0)]
        rows += [("search", 1, 0, 20.0), ("random_search", 2, 0, 12.0)]
        table = pd.DataFrame(rows, columns=["method", "number", "rank", "psnr"]).assign(draw=0)
        path = tmp_path / f"{scene}.searched"
        table.to_parquet(path)
        searched.append(path)
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    _, paths = written(tmp_path, values)
    scenes = [("d", "s0"), ("e", "s0")]
    settings = {"problems": ["d/s0/draw0", "e/s0/draw0"], "scenes": scenes}
    ga_vs_learned(paths, searched, *outputs, **settings, k=20, facts=FACTS)
    means = pd.read_csv(outputs[1]).set_index(["dataset", "method"])["mean"]
    assert means["d", "random_search"] == 12.0
    means = means["all"]
    assert means[["average_search", "average_random"]].tolist() == [15.0, 12.0]
    assert means[["search", "random_search"]].tolist() == [20.0, 12.0]
    text = outputs[0].read_text()
    assert "reconstruct 2 subsets" in text
    assert "2 of 2" in next(line for line in text.splitlines() if "Ours" in line)


def test_a_subset_is_known_by_its_row_in_its_draw(tmp_path):
    """Beyond the stored ones every subset has rank -1."""
    paths = [tmp_path / "0.parquet", tmp_path / "1.parquet"]
    for path in paths:
        rows = {"method": "search", "rank": [0, -1, -1], "subset": [[1, 2], [1, 3], [2, 3]]}
        pd.DataFrame(rows).to_parquet(path)
    picks = searched_subsets(paths)
    subsets = picks.groupby(["draw", *SUBSET])["frame"].agg(list)
    assert subsets.loc[1, "search", 2, -1] == [2, 3]
    assert len(subsets) == 6
