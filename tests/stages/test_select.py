"""Selections of a scene, and their evaluation."""

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.geometry import farthest_views
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.selectors.baselines import METHODS, PRACTICE
from fsel.selectors.pretrained import FILES, FOLDER
from fsel.stages.features import features
from fsel.stages.select import select
from fsel.stages.split import split


def test_selections_nest_and_spare_the_targets(scene, swept):
    problem = Problem.load(scene, swept[0] / "split.parquet")
    assert len(problem.candidates) == 32
    picks = pd.read_parquet(swept[0] / "selections.parquet").sort_values("order")
    nearest = picks[picks["method"] == "nearest"].groupby("k")["frame"].agg(list)
    assert nearest[3] == nearest[5][:3]
    assert picks.loc[picks["method"] == "all", "k"].unique().tolist() == [32]
    pools = picks.groupby("method")["pool"].unique().map(list).to_dict()
    assert pools == {name: [method.pool] for name, method in METHODS.items()}
    proxies = set(problem.proxies)
    assert proxies & set(picks.loc[picks["pool"] == "observed", "frame"]) == proxies
    assert not proxies & set(picks.loc[picks["pool"] == "candidates", "frame"])
    assert picks.loc[picks["method"] == "random", "seed"].nunique() == 3
    targets = Split.load(swept[0] / "split.parquet").targets
    assert not set(targets.tolist()) & set(picks["frame"])
    evaluation = pd.read_parquet(swept[0] / "evaluation.parquet")
    assert len(evaluation) == 4 * len(picks[["method", "seed", "k"]].drop_duplicates())


def test_every_method_begins_with_the_same_views_and_does_not_know_the_targets(scene, tmp_path):
    files = [[tmp_path / f"{name}.parquet"] for name in ("split", "features", "selections")]
    held_out = {"every": 5, "first": 3}
    split(scene, files[0], targets=4, seed=1, hold_out=held_out, config="c")
    features(scene, *files[:2], config="c")
    asked = {"budgets": [4, 6], "seeds": [2], "practice": True, "hold_out": held_out}
    select(scene, *files[:2], [FOLDER / FILES["fsel"]], files[2], **asked, config="c")
    held = Split.load(files[0][0]).targets
    capture = Capture.load(scene)
    assert held.tolist() == list(range(0, len(capture), 5))
    pool = np.setdiff1d(np.arange(len(capture)), held)
    begun = farthest_views(pool, capture.centers, 3, pool[0]).tolist()
    picks = pd.read_parquet(files[2][0]).sort_values("order")
    assert {*METHODS, *PRACTICE, "fsel"} == set(picks["method"])
    for (method, _, k), frames in picks.groupby(["method", "seed", "k"])["frame"]:
        assert frames.tolist()[:3] == begun, method
        assert frames.nunique() == len(frames) == (len(pool) if method == "all" else k)
        assert not set(frames) & set(held)
