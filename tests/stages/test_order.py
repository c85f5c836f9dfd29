"""From a scene to trajectories: searched, ranked, ordered."""

import pandas as pd
import pytest

from fsel.core.files import write_table
from fsel.stages.order import order


def test_labels_rank_subsets_and_trajectories_order_the_best(labelled):
    labels = pd.read_parquet(labelled / "p25.parquet")
    assert sorted(labels["rank"].unique()) == [-1, 0, 1, 2, 3, 4]
    assert labels.loc[labels["rank"] == 0, "fitness"].item() == labels["fitness"].max()
    assert all(len(set(subset)) == 4 for subset in labels["subset"])
    table = pd.read_parquet(labelled / "trajectories.parquet")
    assert table["rank"].tolist() == [0, 1]
    assert table["weight"].mean() == pytest.approx(1)
    assert sorted(table["picks"][0]) == sorted(labels.set_index("rank").loc[0, "subset"])


def test_labels_of_another_split_are_refused(scene, labelled, tmp_path):
    splits = pd.read_parquet(labelled / "splits.parquet")
    table = pd.read_parquet(labelled / "p25.parquet")
    target = int(splits.loc[splits["role"] == "target", "frame"].iloc[0])
    table["subset"] = [[target, *subset[1:]] for subset in table["subset"]]
    old = tmp_path / "old.parquet"
    write_table(table, old, units={}, config="c")
    files = [[labelled / f"{name}.parquet"] for name in ("splits", "features")]
    rest = {"scenes": {"s": "train"}, "coverages": {"s": [25]}, "kept": 2, "config": "c"}
    with pytest.raises(ValueError, match=rf"old.parquet: .* holds frames \[{target}\], which are"):
        order([scene], *files, [old], tmp_path / "t.parquet", **rest)
