"""Targets from a held-out pass: who may be used, and what leads."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from selection_problems import random_capture

from fsel.capture import Capture
from fsel.experiments.crosscapture import (
    BASELINES,
    SHOWN,
    cross_split,
    crosscapture,
    evaluate_crosscapture,
    select_crosscapture,
)
from fsel.metrics import METRICS
from fsel.report.summary import leaders
from fsel.stages.describe import describe
from fsel.synthesis import record

RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
FACTS = {
    "embedded": ["7-Scenes"],
    "real": [],
    "reconstructor": "splats",
    "long_side": 32,
    "descriptor": "lab_hog",
}


def in_passes(sizes: dict[str, int]):
    labels = [name for name, size in sizes.items() for _ in range(size)]
    return replace(random_capture(len(labels)), sequences=tuple(labels))


def placed(capture, centers):
    """The capture, looking one way from given centres."""
    poses = np.tile(np.eye(3, 4), (len(centers), 1, 1))
    poses[:, :, 3] = -np.asarray(centers, float)
    return replace(capture, world_to_camera=poses)


def test_only_the_half_near_another_pass_is_asked_for():
    # pass b stands 0, 9, 1 and 8 away from the frame of pass a that is nearest to it
    along = [0, 10, 20, 30, 40, 0, 49, 11, 28 + 20]
    capture = placed(in_passes({"a": 5, "b": 4}), [(x, 0, 0) for x in along])
    split = cross_split(capture, "b")
    assert split.targets.tolist() == [5, 7]
    assert split.proxies.tolist() == [0, 1]
    assert split.candidates.tolist() == [2, 3, 4]


@pytest.mark.parametrize("held_out", ["a", "b", "c"])
def test_nothing_of_the_held_out_pass_can_be_selected(held_out):
    capture = in_passes({"a": 9, "b": 14, "c": 11})
    split = cross_split(capture, held_out)
    of = np.array(capture.sequences)
    assert set(of[split.targets]) == {held_out}
    assert held_out not in of[np.union1d(split.candidates, split.proxies)]
    assert len(np.unique(split.proxies)) == len(split.targets) == (of == held_out).sum() // 2
    assert len(split.candidates) + len(split.proxies) == (of != held_out).sum()


def test_a_room_of_one_pass_is_refused():
    with pytest.raises(ValueError, match=r"0 frames outside 'a' .* two or more passes"):
        cross_split(in_passes({"a": 12}), "a")


def gap(method, metric, low, high):
    return {"method": method, "k": 10, "metric": metric, "ci_low": low, "ci_high": high}


def test_a_leader_is_ahead_of_everybody_beyond_the_interval():
    rows = [gap("x", "psnr", 0.1, 0.5), gap("x", "psnr", 0.2, 0.9)]
    rows += [gap("y", "psnr", 0.1, 0.5), gap("y", "psnr", -0.1, 0.5)]
    rows += [gap("x", "gmsd", 0.1, 0.5), gap("y", "gmsd", -0.5, -0.1)]
    assert leaders(pd.DataFrame(rows)) == {("x", 10, "psnr"), ("y", 10, "gmsd")}


def test_every_pass_is_held_out_once(tmp_path):
    made = record("seven_scenes", 3, frames=36, width=32, height=24)
    focal = made.camera.params[0]
    camera = np.tile([focal, focal, 16.0, 12.0], (36, 1))
    passes = ("a",) * 12 + ("b",) * 12 + ("c",) * 12
    Capture(made.names, made.world_to_camera, camera, made.images, passes).save(tmp_path)
    describe(tmp_path, tmp_path / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    picks = [tmp_path / "a.parquet", tmp_path / "b.parquet"]
    for path in picks:
        select_crosscapture(tmp_path, [], path, budgets=[4, 8], seed=1, config="c")
    once, again = (pd.read_parquet(path).drop(columns="seconds") for path in picks)
    pd.testing.assert_frame_equal(once, again)
    output = tmp_path / "measured.parquet"
    settings = {"reconstruction": RECONSTRUCTION, "metrics": ["psnr", "gmsd"]}
    evaluate_crosscapture(tmp_path, picks[0], output, **settings, config="c")
    table = pd.read_parquet(output)
    assert "gmsd" in table
    assert "ssim" not in table
    assert set(table["method"]) == set(BASELINES)
    targets = table.groupby("held_out")["target"].unique()
    assert targets.index.tolist() == ["a", "b", "c"]
    for i, (held_out, frames) in enumerate(targets.items()):
        assert set(frames) <= set(range(12 * i, 12 * i + 12)), held_out
    for held_out, part in once.groupby("held_out"):
        assert held_out not in np.array(passes)[part["frame"]]


def test_each_room_and_pass_counts_once(tmp_path):
    rows = []
    for held_out, psnr in (("p", 20.0), ("q", 23.0), ("r", 26.0)):
        for name in SHOWN:
            better = 1.0 if name == "fsel" else 0.0
            # unequal numbers of targets must not weigh a pass
            for target in range(1 if held_out == "p" else 5):
                values = (psnr + better, 0.5 + better / 10, 0.2 - better / 10)
                rows.append((held_out, name, 0, 8, target, *values))
    path = tmp_path / "m.parquet"
    columns = ["held_out", "method", "seed", "k", "target", *METRICS]
    pd.DataFrame(rows, columns=columns).to_parquet(path)
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"scenes": [("d", "room")], "budgets": [8]}
    crosscapture([path], *outputs, **settings, metrics=METRICS, facts=FACTS)
    numbers = pd.read_csv(outputs[1]).query("metric == 'psnr'").set_index("method")
    assert numbers.loc[["fvs", "fsel"], "mean"].tolist() == [23.0, 24.0]
    assert numbers["n"].unique().tolist() == [3]
    assert numbers.index[numbers["leads"]].tolist() == ["fsel"]
    text = outputs[0].read_text()
    assert r"\textbf{fsel} & \textbf{24.00} & \textbf{.600} & \textbf{.100} \\" in text
    assert r"FVS & 23.00 & .500 & .200 \\" in text
    assert r"\multicolumn{3}{c}{$K{=}8$}" in text
