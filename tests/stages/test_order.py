"""From a scene to trajectories: searched, ranked, ordered."""

import pandas as pd
import pytest


def test_labels_rank_subsets_and_trajectories_order_the_best(labelled):
    labels = pd.read_parquet(labelled / "p25.parquet")
    assert sorted(labels["rank"].unique()) == [-1, 0, 1, 2, 3, 4]
    assert labels.loc[labels["rank"] == 0, "fitness"].item() == labels["fitness"].max()
    assert all(len(set(subset)) == 4 for subset in labels["subset"])
    table = pd.read_parquet(labelled / "trajectories.parquet")
    assert table["rank"].tolist() == [0, 1]
    assert table["weight"].mean() == pytest.approx(1)
    assert sorted(table["picks"][0]) == sorted(labels.set_index("rank").loc[0, "subset"])
