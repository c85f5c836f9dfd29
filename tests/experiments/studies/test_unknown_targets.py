"""Selections without a request: what is held out, what is cast off the path, what is compared."""

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene

from fsel.core.capture import Capture
from fsel.experiments.studies import beside
from fsel.experiments.studies import unknown_targets as protocol
from fsel.experiments.studies.unknown_targets import TRIALS, compared, scores_of, unknown_targets

GENERATED = {"family": "dl3dv", "seed": 3, "recorded": 40}  # what write_scene records
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
FACTS = {
    "embedded": ["DL3DV"], "real": [], "reconstructor": "splats", "long_side": 32,
    "descriptor": "lab_hog", "draws": 1,
}  # fmt: skip


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene"))


def test_a_view_without_a_shift_shows_what_its_frame_shows(scene, monkeypatch):
    """But for exposure, vignette, blur, noise and its lens: place and direction are the same."""
    monkeypatch.setattr(beside, "ASIDE", 0.0)
    monkeypatch.setattr(beside, "TURN", 0.0)
    capture = Capture.load(scene)
    views, shown = beside.views_beside(capture, 3, **GENERATED)
    for pose, image in zip(views.world_to_camera, shown, strict=True):
        gap = np.abs(capture.world_to_camera - pose).max(axis=(1, 2))
        assert gap.min() < 1e-9
        likeness = [
            np.corrcoef(image.ravel(), np.asarray(frame).ravel())[0, 1] for frame in capture.images
        ]
        assert likeness[np.argmin(gap)] > 0.85
        assert likeness[np.argmin(gap)] > np.percentile(likeness, 80)


def test_what_is_held_out_is_not_picked_and_what_is_written_becomes_a_table(
    scene, tmp_path, monkeypatch
):
    monkeypatch.setattr(protocol, "COMPARED", ("uniform", "fsel"))
    monkeypatch.setattr(protocol, "STARTS", (3,))
    monkeypatch.setattr(protocol, "BESIDE", 2)
    settings = {"generated": GENERATED, "budgets": [4, 40], "seed": 1}
    files = tmp_path / "picks.parquet", tmp_path / "unknown_targets.parquet"
    TRIALS.select(
        [scene], scene / "descriptors.parquet", [], files[0], settings=settings, config=""
    )
    picks, held = pd.read_parquet(files[0]), np.arange(3, 40, 8)
    assert not set(picks["frame"]) & set(held)
    picked = picks.groupby(["method", "known", "k"], sort=False)["frame"].nunique()
    assert picked.to_dict() == {("uniform", 0, 4): 4, ("fsel", 0, 4): 4, ("fsel", 1, 4): 4}
    measured = {"reconstruction": RECONSTRUCTION, "metrics": ["psnr"], "config": ""}
    TRIALS.evaluate([scene], files[:1], files[1], settings=settings, **measured)
    rows = scores_of("dl3dv/evaluation0", files[1], FACTS)
    assert sorted(set(rows["views"])) == ["held_out", "off_path"]
    assert sorted(set(rows["method"])) == ["fsel", "known", "uniform"]
    assert len(rows) == 2 * 3
    unknown_targets(
        [tmp_path / "unknown_targets.parquet"],
        tmp_path / "unknown_targets.tex",
        tmp_path / "unknown_targets.csv",
        [tmp_path / "unknown_targets.png"],
        scenes=[("dl3dv", "evaluation0")],
        facts=FACTS,
    )
    text = (tmp_path / "unknown_targets.tex").read_text()
    assert text.count(r"\begin{table") == 2
    assert "(+0.00)" in text
    assert (tmp_path / "unknown_targets.png").stat().st_size > 1000


def test_gains_are_paired_by_place():
    """Two places: 20 and 24 dB for uniform, one and three more for fsel; b was filmed twice."""
    rows = pd.DataFrame(
        {
            "views": "held_out",
            "k": 10,
            "method": ["uniform", "fsel"] * 4,
            "scene": ["a"] * 4 + ["b0"] * 2 + ["b1"] * 2,
            "place": ["a"] * 4 + ["b"] * 4,
            "psnr": [19.0, 20, 21, 22, 23, 26, 25, 28],
        }
    )
    found = compared(rows).set_index("method")
    row = found.loc["fsel"]
    assert (row["psnr"], row["gain"], row["least"], row["most"], row["n"]) == (24, 2, 1, 3, 2)
    half = 12.7062 * np.sqrt(2) / np.sqrt(2)  # Student's t of one degree of freedom
    assert (row["ci_low"], row["ci_high"]) == pytest.approx((2 - half, 2 + half), abs=1e-3)
    assert found.loc["uniform", "gain"] == 0
