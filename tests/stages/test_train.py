"""Training: equal seeds, equal files."""

import pandas as pd

from fsel.stages.train import train


def test_equal_trainings_write_equal_files_and_other_seeds_others(scene, labelled, tmp_path):
    for name, seeds in (("a", 2), ("b", 1)):
        train(
            [scene],
            [labelled / "splits.parquet"],
            labelled / "trajectories.parquet",
            [tmp_path / f"{name}{seed}.safetensors" for seed in range(seeds)],
            [tmp_path / f"{name}{seed}.parquet" for seed in range(seeds)],
            scenes=["s"],
            policy="ours",
            epochs=1,
            learning_rate=1e-3,
            config="c",
        )
    written = {path.stem: path.read_bytes() for path in tmp_path.glob("*.safetensors")}
    assert written["a0"] == written["b0"]
    assert written["a0"] != written["a1"]
    assert pd.read_parquet(tmp_path / "a1.parquet")["epoch"].tolist() == [0, 1]
