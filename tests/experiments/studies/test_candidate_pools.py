"""Equal candidate pools: who may pick what, and what is compared with what."""

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene
from evaluation_files import FACTS
from small_sweep import run_trials

from fsel.core.split import Split
from fsel.experiments.studies.candidate_pools import OURS, SETTINGS, TRIALS, candidate_pools
from fsel.experiments.studies.hard_cases.worlds import random_weights
from fsel.selectors import pretrained
from fsel.selectors.baselines import PAPER
from fsel.selectors.scorer import Network


def test_each_block_keeps_to_its_pool(tmp_path):
    folder = write_scene(tmp_path / "scene")
    split = folder / "split.parquet"
    weights = tmp_path / "less_is_more.safetensors"
    Network(random_weights(3), {"policy": "less_is_more", "made by": "a test"}).save(weights)
    rule = pretrained.FOLDER / pretrained.FILES["fsel"]
    asked = {"splits": [split], "settings": {"budgets": [4], "seeds": [1]}}
    found, measured = run_trials(TRIALS, [folder], tmp_path, [weights, rule], **asked)
    roles = Split.load(split)
    pool = {"candidates": roles.candidates}
    pool |= dict.fromkeys(("observed", "targets"), np.union1d(roles.candidates, roles.proxies))
    for (kind, _), part in found.groupby(["setting", "method"]):
        assert set(part["frame"]) <= set(pool[kind])
    by = found.groupby("setting")["method"].agg(set)
    assert by["candidates"] == by["observed"] == {*PAPER, OURS.name}
    assert by["targets"] == {"nearest", "fsel", OURS.name}
    assert len(measured) == len(found) / 4 * len(roles.targets)


def test_ours_stands_beside_the_strongest_of_its_block(tmp_path):
    """Two scenes; ours is ahead of Uniform by 1 and 3, and behind FVS by 1 in both."""
    paths = []
    for scene, ours in (("a", 21.0), ("b", 25.0)):
        rows = []
        for kind in SETTINGS:
            others = {"uniform": ours - (1 if scene == "a" else 3), "fvs": ours + 1}
            others = {"nearest": ours - 2.0} if kind == "targets" else others
            for name, psnr in {**others, "less_is_more": ours}.items():
                rows.append({"draw": 0, "setting": kind, "method": name, "seed": 0, "k": 4})
                rows[-1] |= {"target": 0, "psnr": psnr}
        paths.append(tmp_path / f"{scene}.parquet")
        pd.DataFrame(rows).to_parquet(paths[-1])
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    scenes = [("d", "a"), ("d", "b")]
    candidate_pools(paths, *outputs, scenes=scenes, budgets=[4], facts=FACTS)
    text = outputs[0].read_text()
    assert r"23.00 ($\mathbf{-1.00}$ {\tiny$[-1.00,-1.00]$})" in text
    assert r"23.00 ($\mathbf{+2.00}$ {\tiny$[+2.00,+2.00]$})" in text
    assert "interval over 2 scenes" in text
    gaps = pd.read_csv(outputs[1]).set_index(["setting", "method", "reference"])
    assert gaps.loc[("observed", "less_is_more", "uniform"), "mean"] == pytest.approx(2.0)
    shared = FACTS | {"places": {"d/a": "house", "d/b": "house"}}
    candidate_pools(paths, *outputs, scenes=scenes, budgets=[4], facts=shared)
    assert "interval over 1 scenes" in outputs[0].read_text()
