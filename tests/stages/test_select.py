"""Selections of a scene, and their evaluation."""

import pandas as pd

from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.selectors.baselines import METHODS


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
