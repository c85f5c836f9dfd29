"""What selection and reconstruction cost, beside what they are worth."""

import subprocess

import numpy as np
import pandas as pd
import pytest
from described_scene import filmed

from fsel.core.capture import Capture
from fsel.core.programs import Unfinished
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.summary import ALL_FRAMES
from fsel.experiments.paper import time_quality
from fsel.experiments.paper.time_quality import VARIANTS, _row, cost_means, joined
from fsel.experiments.studies.footprint import footprint, measure_alone
from fsel.reconstruct import reconstructor_of

RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    filmed().save(folder)
    return folder


def test_a_reconstruction_alone_has_the_same_quality_and_its_own_memory(scene):
    frames, targets = np.arange(0, 36, 3), np.array([1, 20, 38])
    few = measure_alone(scene, frames[:4], targets, RECONSTRUCTION)
    many = measure_alone(scene, frames, targets, RECONSTRUCTION)
    reconstructor = reconstructor_of(Capture.load(scene), RECONSTRUCTION)
    expected = Evaluator.on_frames(reconstructor, targets)(frames)[0]
    assert many["psnr"] == pytest.approx(expected, abs=1e-4)
    assert many["peak_bytes"] > few["peak_bytes"] > 0
    assert min(many["fit_seconds"], many["render_seconds"]) > 0


def test_a_reconstruction_that_fails_says_why(scene):
    with pytest.raises(RuntimeError, match=r"1 frames: .*need two or more distinct frames"):
        measure_alone(scene, np.array([1]), np.array([2, 3]), RECONSTRUCTION)
    with pytest.raises(ValueError, match="need two or more"):
        footprint(str(scene), [1], [2, 3], RECONSTRUCTION)


@pytest.mark.parametrize(
    ("code", "memory", "error", "said"),
    [
        (-9, None, Unfinished, ""),
        (-11, 0, Unfinished, ""),
        (-6, 10**9, Unfinished, ""),
        (-11, None, RuntimeError, ""),
        (1, 0, RuntimeError, ""),
        (1, 0, Unfinished, "RuntimeError: can't start new thread"),
        (1, None, RuntimeError, "RuntimeError: can't start new thread"),
    ],
)
def test_a_crash_is_one_of_memory_where_memory_is_limited(
    scene, monkeypatch, code, memory, error, said
):
    ended = subprocess.CompletedProcess([], code, "", said)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: ended)
    with pytest.raises(error, match=f"2 frames: {said or 'exit code'}"):
        measure_alone(scene, np.array([1, 4]), np.array([2]), RECONSTRUCTION, memory=memory)


def costs_of(folder) -> pd.DataFrame:
    for scene, (seconds, peak) in {"a": (1.0, 4e6), "b": (3.0, 8e6)}.items():
        rows = [(10, seconds, 0.5, peak), (ALL_FRAMES, 9.0, 0.5, 1e8)]
        columns = ["k", "fit_seconds", "render_seconds", "peak_bytes"]
        table = pd.DataFrame(rows, columns=columns).assign(device="cpu", outcome="")
        table.to_parquet(folder / f"{scene}.parquet")
    return cost_means([folder / "a.parquet", folder / "b.parquet"])


def table_of(folder, worst: float) -> pd.DataFrame:
    """Ours is one dB ahead of one variant in both scenes, and of the other by 1 and `worst`."""
    values = {
        "less_is_more": [21.0, 23.0],
        "less_is_more_no_appearance": [20.0, 22.0],
        "less_is_more_geometry": [20.0, 23.0 - worst],
        "all": [25.0, 26.0],
    }
    rows = [
        ("d", f"s{i}", "draw0", name, ALL_FRAMES if name == "all" else 10, value)
        for name, pair in values.items()
        for i, value in enumerate(pair)
    ]
    cells = pd.DataFrame(rows, columns=["dataset", "scene", "draw", "method", "k", "psnr"])
    times = [(name, 10, seconds) for name in VARIANTS for seconds in (0.1, 0.3)]
    times = pd.DataFrame(times, columns=["variant", "k", "seconds"])
    return joined(cells, costs_of(folder), times)


def test_a_row_by_hand(tmp_path, monkeypatch):
    record = {"frames": [10], "low": [-0.2], "median": [1.0], "high": [3.0], "bound": [2.0]}
    record |= {"total": [40, 200]}
    monkeypatch.setattr(time_quality, "shipped", lambda: record)
    result = table_of(tmp_path, worst=1.0)
    assert _row(result, "10", 10) == [
        *["10", r"\textbf{22.00}", "21.00", "21.00"],
        *["0.200", "0.200", "0.200", "2.500"],
        *["2.700", "2.700", "2.700", "6"],
        *["-3.50", "-1.0 (-3.0 to +0.2)", "0.26"],
    ]
    every = _row(result, "All", ALL_FRAMES)
    assert every == ["All", "25.50", *["--"] * 5, "9.500", "9.500", "--", "--", "100", *["--"] * 3]


def test_costs_of_what_did_not_finish_are_missing(tmp_path):
    result = table_of(tmp_path, worst=1.0).assign(reconstruction_s=np.nan, peak_mb=np.nan)
    assert _row(result, "10", 10)[4:12] == [*["0.200"] * 3, *["--"] * 5]


def test_a_lead_inside_its_interval_is_not_bold(tmp_path):
    assert _row(table_of(tmp_path, worst=-0.5), "10", 10)[1] == "22.00"
