"""Training: equal seeds, equal files, each read once."""

import numpy as np
import pandas as pd

from fsel.core.files import read_columns
from fsel.core.split import splits_in
from fsel.stages.split import split_labelled
from fsel.stages.train import train
from fsel.training import labelled as reading
from fsel.training.labelled import labelled_problems


def test_equal_trainings_write_equal_files_and_other_seeds_others(scene, labelled, tmp_path):
    read = [[labelled / f"{name}.parquet"] for name in ("splits", "features")]
    read.append(labelled / "trajectories.parquet")
    asked = {"scenes": ["s"], "policy": "less_is_more", "epochs": 1, "learning_rate": 1e-3}
    for name, seeds in (("a", 2), ("b", 1)):
        made = (
            [tmp_path / f"{name}{seed}.{form}" for seed in range(seeds)]
            for form in ("safetensors", "parquet")
        )
        train([scene], *read, *made, **asked, config="c")
    written = {path.stem: path.read_bytes() for path in tmp_path.glob("*.safetensors")}
    assert written["a0"] == written["b0"]
    assert written["a0"] != written["a1"]
    assert pd.read_parquet(tmp_path / "a1.parquet")["epoch"].tolist() == [0, 1]


def test_files_of_a_scene_are_read_once_for_all_levels(scene, tmp_path, monkeypatch):
    splits = tmp_path / "splits.parquet"
    split_labelled(scene, splits, coverages=[25, 50], seed=1, config="c")
    rows = pd.DataFrame({"scene": "s", "coverage": [50, 25, 25], "rank": [0, 1, 0]})
    read = []
    monkeypatch.setattr(reading, "read_columns", lambda p: read.append(p) or read_columns(p))
    problems = list(labelled_problems(rows, {"s": (scene, splits)}))
    assert read == [scene / "descriptors.parquet", splits]
    assert [[row["rank"] for row in part] for _, part in problems] == [[0, 1], [0]]
    for (problem, _), (_, split) in zip(problems, splits_in(read_columns(splits)), strict=True):
        np.testing.assert_array_equal(problem.candidates, split.candidates)
    assert problems[0][0].capture is problems[1][0].capture
