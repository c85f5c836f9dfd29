"""Selectors on inexact poses: what is held fixed, what is compared."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from described_scene import filmed, save_described
from matplotlib.figure import Figure

from fsel.captures.poses import sfm
from fsel.core.capture import Capture
from fsel.experiments.paper.estimate_poses import estimate_poses
from fsel.experiments.paper.pose_errors import perturbed, pose_errors
from fsel.experiments.paper.pose_trials import ESTIMATES, NOISE, SELECTORS
from fsel.experiments.paper.poses import MARKED, changes, poses
from fsel.metrics import METRICS

DRAWN = {"targets": 3, "split_seed": 2, "budgets": [4], "seed": 1}
MEASURED = {
    "reconstruction": {"name": "splats", "long_side": 32, "settings": {}},
    "metrics": METRICS,
}
FACTS = {
    "embedded": ["DL3DV"],
    "real": [],
    "reconstructor": "splats",
    "long_side": 32,
    "descriptor": "lab_hog",
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture, described."""
    return save_described(filmed(24), tmp_path_factory.mktemp("scene"))


def psnr(table, **chosen):
    """Mean PSNR of the rows with the chosen values, by method and seed."""
    for column, value in chosen.items():
        table = table[table[column] == value]
    return table.groupby(["method", "seed"])["psnr"].mean()


def estimated(given, found, folder, draws):
    """What picks on given and on other poses are worth."""
    picks, output = folder / "p.parquet", folder / "m.parquet"
    asked = {"settings": {"draws": draws, **DRAWN}, "config": "c"}
    ESTIMATES.select([given, found], given / "descriptors.parquet", [], picks, **asked)
    ESTIMATES.evaluate([given, found], [picks], output, **asked, **MEASURED)
    return pd.read_parquet(output)


def test_the_selector_s_noise_leaves_the_reconstruction_alone(scene, tmp_path):
    picks, output = tmp_path / "a.parquet", tmp_path / "m.parquet"
    levels = {"degrees": [20.0], "percent": [40.0]}
    asked = {"settings": {"levels": levels, "noises": 2, **DRAWN}, "config": "c"}
    found = []
    for path in (tmp_path / "b.parquet", picks):
        NOISE.select([scene], scene / "descriptors.parquet", [], path, **asked)
        found.append(pd.read_parquet(path).drop(columns="seconds"))
    pd.testing.assert_frame_equal(*found)
    NOISE.evaluate([scene], [picks], output, **asked, **MEASURED)
    table = pd.read_parquet(output)
    assert set(table["method"]) == set(SELECTORS)
    exact = psnr(table, change="none")
    for change in levels:
        for noise in (0, 1):
            case = {"change": change, "noise": noise}
            seen, both = (psnr(table, **case, scope=s) for s in ("selector", "both"))
            # a method that does not look at poses picks the same, and nothing else has changed
            for name in ("random", "sharpest"):
                pd.testing.assert_series_equal(seen[[name]], exact[[name]])
                assert (both[name] != exact[name]).all()
            assert (seen != exact).any()


def test_two_sets_of_poses_that_are_one_make_no_difference(scene, tmp_path):
    table = estimated(scene, scene, tmp_path, draws=2)
    for draw in (0, 1):
        exact = psnr(table, change="none", draw=draw)
        for scope in ("selector", "both"):
            found = psnr(table, change="estimated", scope=scope, draw=draw)
            pd.testing.assert_series_equal(found, exact)
    assert (psnr(table, draw=0) != psnr(table, draw=1)).any()


def test_estimated_poses_are_those_that_the_reconstruction_renders(scene, tmp_path):
    found = filmed(24)
    # COLMAP's own world: turned, shifted and scaled, which nothing may notice
    turn = np.array([(0.0, 0, 1), (1, 0, 0), (0, 1, 0)])
    turned = found.world_to_camera[:, :, :3] @ turn.T
    shift = 3 * found.world_to_camera[:, :, 3] - turned @ np.array([1.0, -2, 0.5])
    elsewhere = np.concatenate([turned, shift[..., None]], axis=2)
    replace(found, world_to_camera=elsewhere).save(tmp_path / "estimated")
    table = estimated(scene, tmp_path / "estimated", tmp_path, draws=1)
    exact = psnr(table, change="none")
    np.testing.assert_allclose(psnr(table, change="estimated", scope="both"), exact, atol=0.02)


def test_both_captures_hold_the_frames_that_were_placed(tmp_path, monkeypatch):
    whole = replace(
        filmed(24), images=np.random.default_rng(0).integers(0, 255, (24, 24, 32, 3), "u1")
    )
    kept = np.setdiff1d(np.arange(12), [3, 7])

    def placed(capture):
        found = perturbed(capture.world_to_camera, 2, 1, np.random.default_rng(0))[kept]
        return kept, found, None

    monkeypatch.setattr(sfm, "estimate", placed)
    reader = "fsel.experiments.paper.estimate_poses.read_folder"
    monkeypatch.setattr(reader, lambda *_, **__: type("Found", (), {"capture": whole}))
    folders = tmp_path / "given", tmp_path / "estimated"
    sizes = {"frames": 12, "matching_side": 32, "long_side": 16}
    errors = tmp_path / "errors.parquet"
    settings = {**sizes, "reading": {}, "config": "c"}
    estimate_poses("raw", *folders, errors, at_least=10, **settings)
    given, estimated = (Capture.load(folder) for folder in folders)
    used = np.linspace(0, 23, 12).round().astype(int)[kept]
    assert given.names == estimated.names == tuple(whole.names[i] for i in used)
    np.testing.assert_array_equal(given.images, estimated.images)
    np.testing.assert_array_equal(given.world_to_camera, whole.world_to_camera[used])
    np.testing.assert_array_equal(given.intrinsics, estimated.intrinsics)
    assert pose_errors(estimated.world_to_camera, given.world_to_camera)[0].max() > 0.1
    assert given.size == (16, 12)
    table = pd.read_parquet(errors)
    assert (len(table), table["placed"].sum()) == (12, 10)
    assert table["degrees"].notna().tolist() == table["placed"].tolist()
    assert 0 < table["degrees"].max() < 10
    with pytest.raises(ValueError, match="raw: COLMAP placed 10 of 12 frames, 11 are needed"):
        estimate_poses("raw", *folders, errors, at_least=11, **settings)


def written(folder, scene, rows):
    """A measurement: rows are change, level, scope, noise, method, PSNR."""
    columns = ["change", "level", "scope", "noise", "method", "psnr"]
    table = pd.DataFrame(rows, columns=columns)
    values = {"draw": 0, "seed": 0, "k": 8} | {m: 0.5 for m in METRICS if m != "psnr"}
    path = folder / f"{scene}.parquet"
    table.assign(**values).to_parquet(path)
    return {"dataset": "d", "scene": scene, "path": path}


def test_changes_are_paired_within_scenes(tmp_path):
    items = []
    for scene, base in (("a", 10.0), ("b", 20.0), ("c", 30.0)):
        rows = [("none", 0.0, "both", 0, "fvs", base)]
        # two seeds of noise, -1 and -3: the mean of every scene falls by 2
        rows += [("degrees", 5.0, "both", n, "fvs", base - 1 - 2 * n) for n in (0, 1)]
        items.append(written(tmp_path, scene, rows))
    table = changes(items).set_index("change")
    assert table.loc["degrees", ["mean", "difference"]].tolist() == [18.0, -2.0]
    bounds = ["difference_low", "difference_high"]
    np.testing.assert_allclose(table.loc["degrees", bounds].astype(float), -2.0)
    assert table.loc["none", ["mean", "difference"]].tolist() == [20.0, 0.0]
    assert table.loc["degrees", "ci_high"] - table.loc["degrees", "ci_low"] > 5
    assert table["n"].tolist() == [3, 3]


def measurements(folder):
    noise, estimated = [], []
    for scene, base in (("a", 20.0), ("b", 22.0)):
        rows = []
        for method in MARKED:
            rows.append(("none", 0.0, "both", 0, method, base))
            for change in ("degrees", "percent"):
                rows.append((change, 3.0, "selector", 0, method, base + 0.5))
                # falls in one scene and rises in the other: no verdict
                rows.append((change, 3.0, "both", 0, method, base + base - 21))
        noise.append(written(folder, scene, rows))
        rows = []
        for method in MARKED:
            rows.append(("none", np.nan, "both", 0, method, base))
            rows += [("estimated", np.nan, s, 0, method, base - 1) for s in ("selector", "both")]
        estimated.append(written(folder, f"{scene}_estimated", rows))
    return estimated, noise


@pytest.fixture
def made(tmp_path, monkeypatch):
    """The tables' text and numbers, the figure and its numbers."""
    shown = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: shown.append(self))
    estimated, noise = ([item["path"] for item in items] for items in measurements(tmp_path))
    errors = tmp_path / "e.parquet", tmp_path / "f.parquet"
    values = {"name": list("abc"), "placed": [True, True, False]}
    values |= {"degrees": [1.0, 2.0, np.nan], "percent": [0.5, 0.25, np.nan]}
    pd.DataFrame(values).to_parquet(errors[0])
    values = {"name": ["d"], "placed": [True], "degrees": [0.5], "percent": [0.1]}
    pd.DataFrame(values).to_parquet(errors[1])
    outputs = tmp_path / "t.tex", tmp_path / "t.csv", [tmp_path / "f.png"], tmp_path / "n.csv"
    settings = {"scenes": [("d", "a"), ("d", "b")], "budgets": [8]}
    settings |= {"facts": FACTS}
    poses(estimated, noise, errors, *outputs, **settings)
    return outputs[0].read_text(), pd.read_csv(outputs[1]), shown[0], pd.read_csv(outputs[3])


def test_the_tables_say_what_poses_cost(made):
    text, numbers, *_ = made
    cell = r"$\mathbf{-1.00}$ {\tiny$[-1.00,-1.00]$}"
    assert rf"FVS & 21.00 & {cell} & {cell} \\" in text
    gained, unsure = r"$\mathbf{+0.50}$", r"$+0.00$"
    assert rf"FVS & 21.00 & {gained} & {gained} & {unsure} & {unsure} \\" in text
    assert r"Selection & exact & $3^\circ$ & $3\%$ & $3^\circ$ & $3\%$ \\" in text
    assert r"\multicolumn{2}{c}{selector alone}" in text
    assert "placed 3 of 4 frames" in text
    assert r"$0.50^\circ$ to $1.50^\circ$ and 0.10\% to 0.38\% of the scene" in text
    assert numbers.groupby("captures")["method"].size().tolist() == [3 * 8, 5 * 8]


def test_the_figure_shows_every_level_of_every_selector(made):
    *_, figure, numbers = made
    assert len(numbers) == 5 * len(MARKED)
    axes = figure.axes
    assert [len(axis.lines) for axis in axes] == [len(MARKED)] * 4
    assert [label.get_text() for label in axes[2].get_xticklabels()] == ["0", "3"]
    np.testing.assert_allclose(axes[0].lines[0].get_ydata(), [21.0, 21.5])
    np.testing.assert_allclose(axes[3].lines[0].get_ydata(), [21.0, 21.0])
