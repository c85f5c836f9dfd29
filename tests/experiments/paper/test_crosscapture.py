"""Targets from a held-out pass: who may be used, and what leads."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from described_scene import filmed, save_described
from evaluation_files import FACTS
from selection_problems import random_capture
from small_sweep import run_trials

from fsel.experiments.paper.crosscapture import (
    BASELINES,
    SHOWN,
    TRIALS,
    cross_split,
    crosscapture,
    thinned,
    trials,
)
from fsel.metrics import METRICS


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


def test_every_pass_is_held_out_once(tmp_path):
    passes = ("a",) * 12 + ("b",) * 12 + ("c",) * 12
    save_described(replace(filmed(36, "seven_scenes"), sequences=passes), tmp_path)
    settings = {"held_out": [], "every": 1, "targets": None, "draws": 3, "seed": 1}
    asked = {"settings": settings | {"budgets": [4, 8]}, "metrics": ["psnr", "gmsd"]}
    picks, table = run_trials(TRIALS, [tmp_path], tmp_path, **asked)
    assert "gmsd" in table
    assert "ssim" not in table
    assert set(table["method"]) == set(BASELINES)
    targets = table.groupby("held_out")["target"].unique()
    assert targets.index.tolist() == ["a", "b", "c"]
    for i, (held_out, frames) in enumerate(targets.items()):
        assert set(frames) <= set(range(12 * i, 12 * i + 12)), held_out
    for held_out, part in picks.groupby("held_out"):
        assert held_out not in np.array(passes)[part["frame"]]


def test_a_sequence_split_holds_all_its_passes_back_and_draws_targets(tmp_path):
    capture = in_passes({"a": 20, "b": 20, "c": 20, "d": 20})
    np.testing.assert_array_equal(thinned(tuple("aaaabbbbb"), 3), [0, 3, 4, 7])
    part = capture.subset(thinned(capture.sequences, 2))
    asked = {"every": 2, "budgets": [4], "seed": 5}
    made = list(trials(capture, held_out=["b", "d"], targets=3, draws=2, **asked))
    keys = [tuple(trial.key.values()) for trial in made]
    assert keys == [("b", 0), ("b", 1), ("d", 0), ("d", 1)]
    of = np.array(part.sequences)
    for trial in made:
        split = trial.split
        assert len(split.targets) == len(split.proxies) == 3
        assert set(of[split.targets]) == {trial.key["held_out"]}
        assert set(of[np.union1d(split.candidates, split.proxies)]) == {"a", "c"}
        assert len(split.candidates) + 3 == 20
        near = cross_split(part, trial.key["held_out"], others=["b", "d"]).targets
        assert set(split.targets) < set(near)
    assert set(made[0].split.targets) != set(made[1].split.targets)
    with pytest.raises(ValueError, match=r"held_out has \['e'\]; its passes are \['a', 'b'"):
        list(trials(capture, held_out=["e"], targets=3, draws=1, **asked))
    with pytest.raises(ValueError, match="5 in the half of it that targets come from, for 6"):
        list(trials(capture, held_out=["b"], targets=6, draws=1, **asked))
    with pytest.raises(ValueError, match=r"0 frames outside 'a' .* two or more passes"):
        cross_split(in_passes({"a": 12}), "a")


def test_passes_of_a_room_are_one_place(tmp_path):
    """Two rooms: three passes in one, one in the other; each room counts once."""
    rooms = {"one": (("p", 20.0), ("q", 23.0), ("r", 26.0)), "two": (("p", 30.0),)}
    columns = ["held_out", "draw", "method", "seed", "k", "target", *METRICS]
    paths = []
    for room, measured in rooms.items():
        rows = []
        for held_out, psnr in measured:
            for name in SHOWN:
                better = 1.0 if name == "fsel" else 0.0
                # unequal numbers of targets must not weigh a pass
                for target in range(1 if held_out == "p" else 5):
                    values = (psnr + better, 0.5 + better / 10, 0.2 - better / 10)
                    rows.append((held_out, 0, name, 0, 8, target, *values))
        paths.append(tmp_path / f"{room}.parquet")
        pd.DataFrame(rows, columns=columns).to_parquet(paths[-1])
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    settings = {"scenes": [("d", "one"), ("d", "two")], "budgets": [8]}
    crosscapture(paths, *outputs, **settings, metrics=METRICS, facts=FACTS)
    numbers = pd.read_csv(outputs[1]).query("metric == 'psnr'").set_index("method")
    assert numbers.loc[["fvs", "fsel"], "mean"].tolist() == [26.5, 27.5]
    assert numbers["n"].unique().tolist() == [2]
    assert numbers.index[numbers["leads"]].tolist() == ["fsel"]
    text = outputs[0].read_text()
    assert r"\textbf{fsel} & \textbf{27.50} & \textbf{.600} & \textbf{.100} \\" in text
    assert r"FVS & 26.50 & .500 & .200 \\" in text
    assert r"\multicolumn{3}{c}{$K{=}8$}" in text
    assert "4 pairs of room and held-out pass, averaged within each of 2 rooms" in text
