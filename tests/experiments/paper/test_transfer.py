"""Frozen picks under other reconstructors, and what each reconstructor makes of all frames."""

import numpy as np
import pandas as pd
import pytest
from described_scene import filmed
from evaluation_files import FACTS, written

from fsel.core.split import Split
from fsel.evaluation.summary import ALL_FRAMES, read_csv
from fsel.experiments.paper.time_quality import cost_means
from fsel.experiments.paper.transfer import (
    SHOWN,
    evaluate_reconchoice,
    evaluate_transfer,
    reconchoice,
    transfer,
)

RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
RECONSTRUCTORS = {
    "splats": {"reconstructor": "splats", "long_side": 96},
    "g_2": {"reconstructor": "g_2 (gaussians)", "long_side": 64},
}
TOLD = {"budgets": [30], "seeds": [0], "metrics": ["psnr"], "facts": FACTS}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small capture, a split and picks that no method of the library would make."""
    folder = tmp_path_factory.mktemp("scene")
    capture = filmed(20)
    capture.save(folder)
    candidates = np.setdiff1d(np.arange(20), [1, 9, 2, 10])
    split = Split(np.array([1, 9]), np.array([2, 10]), candidates, candidates)
    pd.DataFrame(split.table(capture.names)).to_parquet(folder / "split.parquet")
    rows = [(m, s, 3, i) for m in ("fvs", "less_is_more") for s in (0, 1) for i in (3 + s, 7, 13)]
    rows += [("fvs", 0, 4, i) for i in (3, 5, 7, 13)] + [("sharpest", 0, 3, i) for i in (3, 4, 5)]
    rows += [("all", 0, 16, i) for i in candidates]
    picks = pd.DataFrame(rows, columns=["method", "seed", "k", "frame"])
    picks.to_parquet(folder / "selections.parquet")
    return folder


def test_the_picks_asked_for_are_measured_and_no_others(scene, tmp_path):
    paths = [scene / "split.parquet"], [scene / "selections.parquet"], [tmp_path / "t.parquet"]
    how = {"reconstruction": RECONSTRUCTION, "metrics": ["psnr"], "budgets": [3], "seeds": [0]}
    evaluate_transfer(scene, *paths, **how, config="c")
    table = pd.read_parquet(tmp_path / "t.parquet")
    found = table[["method", "seed", "k", "target"]].values.tolist()
    assert found == [[m, 0, 3, t] for m in ("fvs", "less_is_more") for t in (1, 9)]
    by_method = table.set_index("method")["psnr"]
    assert by_method["fvs"].tolist() == by_method["less_is_more"].tolist()  # the same frames
    assert set(table["device"]) == {"cpu"}


def test_differences_are_paired_within_a_reconstructor(tmp_path):
    problems, paths = [], []
    for lead in (1.0, 3.0):
        more = dict.fromkeys(SHOWN, 0) | {"less_is_more": lead, "fsel": 0.5}
        values = {
            (scene, "draw0"): {(name, 0, 30): base + gain for name, gain in more.items()}
            for scene, base in (("a", 20.0), ("b", 24.0))
        }
        (tmp_path / str(lead)).mkdir()
        problems, own = written(tmp_path / str(lead), values)
        paths += own
    outputs = [tmp_path / name for name in ("t.tex", "t.csv", "d.csv")]
    transfer(paths, *outputs, problems=problems, reconstructors=RECONSTRUCTORS, **TOLD)
    means = read_csv(outputs[1]).set_index(["reconstructor", "method"])["mean"]
    assert means["splats", "random"] == means["g_2", "random"] == 22
    assert (means["splats", "less_is_more"], means["g_2", "less_is_more"]) == (23, 25)
    gaps = read_csv(outputs[2]).set_index(["reconstructor", "method", "reference"])
    assert gaps.loc[("splats", "less_is_more", "nearest"), "mean"] == 1
    assert gaps.loc[("g_2", "less_is_more", "fsel"), "mean"] == 2.5
    assert gaps.loc[("g_2", "fsel", "random"), ["ci_low", "ci_high"]].tolist() == [0.5, 0.5]
    text = outputs[0].read_text()
    assert r"\texttt{g\_2 (gaussians)} at" in text
    assert "2 scenes, 2 draws" in text
    assert "not the corpora themselves" in text
    first, second = [line for line in text.splitlines() if line.startswith("Random & ")]
    assert first.count("22.00") == second.count("22.00") == 1
    assert r"$\mathbf{+1.00}$" in first
    assert r"$\mathbf{+3.00}$" in second
    for own in (line for line in text.splitlines() if line.startswith(rf"{SHOWN['fsel']} & ")):
        assert own.split(" & ")[3] == r" \\"  # fsel minus itself


ASKED = {"reconstruction": RECONSTRUCTION, "metrics": ["psnr", "ssim"], "budgets": [3]}


def chosen(scene, folder, memory):
    paths = scene / "split.parquet", scene / "selections.parquet", folder / "r.parquet"
    evaluate_reconchoice(scene, *paths, **ASKED, seeds=[0], memory=memory, config="c")
    table = pd.read_parquet(paths[2]).set_index("k")
    assert table.index.tolist() == [3, ALL_FRAMES]
    return table


def test_few_frames_and_all_are_measured_alone(scene, tmp_path):
    table = chosen(scene, tmp_path, 10**9)
    assert (table.drop(columns=["device", "outcome"]) > 0).all(axis=None)
    assert set(table["device"] + table["outcome"]) == {"cpu"}
    assert table.loc[ALL_FRAMES, "psnr"] > table.loc[3, "psnr"] + 3


def test_what_does_not_fit_the_memory_is_a_result(scene, tmp_path):
    table = chosen(scene, tmp_path, 0)
    assert table.drop(columns=["device", "outcome"]).isna().all(axis=None)
    assert table["outcome"].tolist() == ["out of memory"] * 2


def choice(folder, values):
    paths = []
    for at, (psnr, seconds, peak) in enumerate(values):
        ended = "out of memory" if np.isnan(psnr) else ""
        rows = [(20, 20.0, 1.0, 0.5, 4e6, "cpu", "")]
        rows.append((ALL_FRAMES, psnr, seconds, 0.0, peak, "" if ended else "cpu", ended))
        columns = ["k", "psnr", "fit_seconds", "render_seconds", "peak_bytes", "device", "outcome"]
        paths.append(folder / f"{at}-{seconds}.parquet")
        pd.DataFrame(rows, columns=columns).to_parquet(paths[-1])
    return paths


def test_one_scene_out_of_memory_is_said_and_not_averaged_away(tmp_path):
    fits = choice(tmp_path, [(22.0, 3.0, 8e6), (24.0, 5.0, 1e7)])
    nan = float("nan")
    full = choice(tmp_path, [(22.0, 3.5, 8e6), (nan, nan, nan)])
    for path in fits:
        pd.read_parquet(path).assign(device="H_1").to_parquet(path)
    means = cost_means(full, ["psnr"])
    assert means["outcome"].tolist() == ["", "out of memory"]
    assert np.isnan(means["psnr"][ALL_FRAMES])
    told = {"metrics": ["psnr"], "memory": 8 * 10**9, "facts": FACTS, "problems": ["d/s/draw0"]}
    told["reconstructors"] = RECONSTRUCTORS
    reconchoice([*fits, *full], tmp_path / "r.tex", tmp_path / "r.csv", **told)
    lines = (tmp_path / "r.tex").read_text().splitlines()
    assert r"$K{=}20$ & 20.00 & 1.5 & 4 & 20.00 & 1.5 & 4 \\" in lines
    assert r"all frames & 23.00 & 4.0 & 9 & \textit{out of memory} &  &  \\" in lines
    assert any("may take 8~GB" in line for line in lines)
    assert any(r"memory of the GPU: \texttt{splats} (H\_1)." in line for line in lines)


def test_what_did_not_finish_is_said_in_the_place_of_numbers(tmp_path):
    values = {(s, "draw0"): {(m, 0, 30): 20.0 for m in SHOWN} for s in "ab"}
    problems, paths = written(tmp_path, values)
    table = pd.read_parquet(paths[1]).assign(outcome="")
    table.loc[table["method"] == "random", ["psnr", "outcome"]] = np.nan, "timeout"
    table.to_parquet(paths[1])
    outputs = [tmp_path / name for name in ("t.tex", "t.csv", "d.csv")]
    named = {"splats": RECONSTRUCTORS["splats"]}
    transfer(paths, *outputs, problems=problems, reconstructors=named, **TOLD)
    lines = outputs[0].read_text().splitlines()
    assert r"Random & \textit{timeout} &  &  \\" in lines
    means = read_csv(outputs[1]).set_index("method")
    assert np.isnan(means.loc["random", "mean"])
    assert means.loc["random", ["n", "outcome"]].tolist() == [0, "timeout"]
    assert means.loc["fvs", "mean"] == 20
