"""Labels by another reconstructor than the one that evaluates."""

import numpy as np
import pandas as pd
import pytest
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.core.capture import Capture
from fsel.core.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import METRICS
from fsel.reconstruct import reconstructor_of
from fsel.stages.label import label

ASKED = {"seed": 5, "search": SEARCH, "inputs": [], "coverage": 25, "fitness": METRICS}
ASKED["config"] = "c"
GAUSSIANS = {"name": "gaussians", "long_side": 24, "settings": {"steps": 3, "gaussians": 100}}


def test_a_search_by_gaussians_measures_by_gaussians(scene, labelled, tmp_path):
    splits, path = labelled / "splits.parquet", tmp_path / "p25.parquet"
    label(scene, splits, path, reconstruction=GAUSSIANS, **ASKED)
    labels, usual = pd.read_parquet(path), pd.read_parquet(labelled / "p25.parquet")
    split = Split.from_table(pd.read_parquet(splits))
    reconstructor = reconstructor_of(Capture.load(scene), GAUSSIANS)
    evaluator = Evaluator.on_frames(reconstructor, split.proxies)
    best = labels[labels["rank"] == 0].iloc[0]
    measured = evaluator(np.asarray(best["subset"]))
    np.testing.assert_allclose(measured, best[list(METRICS)].to_numpy(float), rtol=1e-9)
    # both searches begin with the same subsets, which the two reconstructors rank differently
    begun = [table[table["generation"] == 0] for table in (labels, usual)]
    first, other = ([tuple(s) for s in table["subset"]] for table in begun)
    assert first == other
    assert (begun[0]["psnr"].to_numpy() != begun[1]["psnr"].to_numpy()).all()


def test_a_search_that_was_killed_goes_on_from_its_journal(scene, labelled, tmp_path, kill):
    settings = ASKED | {"reconstruction": RECONSTRUCTION}
    splits, path, calls = labelled / "splits.parquet", tmp_path / "p25.parquet", kill(3)
    with pytest.raises(KeyboardInterrupt):
        label(scene, splits, path, **settings)
    label(scene, splits, path, **settings)
    made, usual = pd.read_parquet(path), pd.read_parquet(labelled / "p25.parquet")
    pd.testing.assert_frame_equal(made, usual)
    assert len(calls) == len(usual) + 1  # the killed one is evaluated again
    assert not list(tmp_path.glob(".*.journal"))
