"""The search that selection is compared with."""

import pandas as pd
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.metrics import METRICS
from fsel.stages.search_oracle import search_oracle
from fsel.stages.split import split


def test_oracle_beats_its_own_first_subset(scene, tmp_path):
    split(scene, [tmp_path / "split.parquet"], targets=4, seed=1, config="c")
    search_oracle(
        scene,
        tmp_path / "split.parquet",
        tmp_path / "subsets.parquet",
        tmp_path / "oracle.parquet",
        search=SEARCH,
        reconstruction=RECONSTRUCTION,
        fitness=METRICS,
        metrics=METRICS,
        seed=0,
        inputs=[],
        config="c",
    )
    subsets = pd.read_parquet(tmp_path / "subsets.parquet")
    counts = subsets["method"].value_counts()
    assert counts["search"] == counts["random_search"]
    oracle = pd.read_parquet(tmp_path / "oracle.parquet")
    assert set(oracle["method"]) == {"search", "random_search"}
    assert oracle["k"].unique().tolist() == [4]
    assert list(tmp_path.glob(".*journal")) == []
