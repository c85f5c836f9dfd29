"""The search that selection is compared with."""

import pandas as pd
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.metrics import METRICS
from fsel.stages.search_oracle import search_oracle
from fsel.stages.split import split


def test_oracle_beats_its_own_first_subset(scene, tmp_path):
    paths = [tmp_path / f"{name}.parquet" for name in ("split", "subsets", "oracle")]
    split(scene, paths[:1], targets=4, seed=1, config="c")
    settings = {"search": SEARCH, "reconstruction": RECONSTRUCTION, "seed": 0, "inputs": []}
    search_oracle(scene, *paths, **settings, fitness=METRICS, metrics=METRICS, config="c")
    _, subsets, oracle = map(pd.read_parquet, paths)
    counts = subsets["method"].value_counts()
    assert counts["search"] == counts["random_search"]
    assert set(oracle["method"]) == {"search", "random_search"}
    assert oracle["k"].unique().tolist() == [4]
    assert list(tmp_path.glob(".*journal")) == []
