"""What swaps gain, over scenes."""

import numpy as np
import pandas as pd
import pytest

from fsel.evaluation.numbers import read_csv
from fsel.experiments.studies.swaps import BY, TRIED, gains, swaps


def scene(psnr, tried=TRIED):
    """PSNR of the targets as it is measured, a second a subset."""
    rows = {"tried": tried, "seconds": tried, "estimate": 0.5, "psnr": psnr}
    return pd.DataFrame(rows).set_index(BY)["psnr"]


def test_gains_are_over_the_start_of_each_scene():
    scenes = [scene(20 + np.arange(len(TRIED))), scene(30 + 3 * np.arange(len(TRIED)))]
    found = gains(scenes)
    np.testing.assert_array_equal(found["gain"], 2 * np.arange(len(TRIED)))
    np.testing.assert_array_equal(found["least"], np.arange(len(TRIED)))
    np.testing.assert_array_equal(found["seconds"], TRIED)
    # two scenes at 2 +- 1: t of 97.5 % at one degree of freedom is 12.706, the error of the mean 1
    assert found["ci_low"][1] == pytest.approx(2 - 12.7062, abs=1e-4)
    assert (found["n"] == 2).all()


def test_a_scene_without_further_swaps_keeps_its_last_picks():
    found = gains([scene([20.0, 21.0], TRIED[:2]), scene(np.full(len(TRIED), 30.0))])
    np.testing.assert_array_equal(found["gain"], [0] + [0.5] * (len(TRIED) - 1))


def test_the_figure_has_its_numbers_beside_it(tmp_path):
    files = [tmp_path / "a.parquet", tmp_path / "b.parquet"]
    for at, path in enumerate(files):
        scene(20 + at * np.arange(len(TRIED))).reset_index().to_parquet(path)
    facts = {"embedded": ["X"], "real": []}
    figures = [tmp_path / "swaps.png", tmp_path / "swaps.pdf"]
    swaps(files, figures, tmp_path / "swaps.csv", k=20, facts=facts)
    assert all(path.stat().st_size > 1000 for path in figures)
    assert read_csv(tmp_path / "swaps.csv")["gain"].iloc[-1] == (len(TRIED) - 1) / 2
