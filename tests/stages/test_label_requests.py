"""Requests of a scene through their stage."""

import numpy as np
import pandas as pd
import pytest
from small_sweep import RECONSTRUCTION

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.reconstruct import reconstructor_of
from fsel.split import Split, targets_at
from fsel.stages.label_requests import label_requests


@pytest.fixture
def labelled(scene, tmp_path):
    """What the stage wrote, and how to call it again."""

    def make(**changes):
        settings = {"coverages": [25], "draws": 2, "budgets": [4], "seed": 5, "inputs": []}
        settings |= {"search": {"evaluations": 6, "exchanged": 1, "generations": 0}, "config": "c"}
        settings |= {"reconstruction": RECONSTRUCTION} | changes
        paths = tmp_path / "requests.parquet", tmp_path / "splits.parquet"
        label_requests(scene, *paths, **settings)
        return [pd.read_parquet(path) for path in paths]

    return make


def test_scores_are_of_the_targets_by_subsets_without_them(scene, labelled):
    labels, splits = labelled()
    assert labels["request"].unique().tolist() == [0, 1]
    reconstructor = reconstructor_of(Capture.load(scene), RECONSTRUCTION)
    drawn = []
    for request, rows in labels.groupby("request"):
        split = Split.from_table(splits[splits["request"] == request])
        assert len(split.targets) == targets_at(25)
        drawn.append(split.targets.tolist())
        picked = np.stack(rows["subset"].to_list())
        assert picked.shape == (6, 4)
        assert not np.isin(picked, split.targets).any()
        evaluator = Evaluator.on_frames(reconstructor, split.targets, metrics=("psnr",))
        last = rows.iloc[-1]
        assert evaluator(np.array(last["subset"]))[0] == pytest.approx(last["psnr"])
    assert drawn[0] != drawn[1]


def test_a_search_that_was_stopped_goes_on(labelled, tmp_path, monkeypatch):
    whole, _ = labelled()
    calls = []
    real = Evaluator.__call__

    def stopped(self, subset):
        calls.append(subset)
        if len(calls) == 4 + 9:  # four are timed
            raise KeyboardInterrupt
        return real(self, subset)

    monkeypatch.setattr(Evaluator, "__call__", stopped)
    with pytest.raises(KeyboardInterrupt):
        labelled()
    labels, _ = labelled()
    # eight subsets were known of twelve
    assert len(calls) == 4 + 9 + 4 + 4
    pd.testing.assert_frame_equal(labels, whole)
    assert not list(tmp_path.glob(".*journal"))
