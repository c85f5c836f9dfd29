"""The paper's other figures: their numbers, on small captures."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene
from selection_problems import random_capture

from fsel.core.capture import Capture
from fsel.core.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.figures import plan_positions
from fsel.experiments.paper.pictures import (
    STRONGEST,
    _calmest,
    qualitative,
    real_world,
    resolved,
)
from fsel.experiments.paper.pipeline_figure import met_until, pipeline_figure
from fsel.reconstruct import reconstructor_of
from fsel.selection.paths import upwards

RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
FACTS = {"embedded": ["DL3DV"], "real": [], "reconstructor": "splats", "long_side": 32}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with one draw of targets and two selections."""
    folder = write_scene(tmp_path_factory.mktemp("scene"))
    observed = np.setdiff1d(np.arange(40), targets_of(folder))
    rows = [("all", 0, len(observed), i, f) for i, f in enumerate(observed)]
    rows += [("uniform", s, 8, i, f) for s in (0, 1) for i, f in enumerate(observed[s::4][:8])]
    columns = ["method", "seed", "k", "order", "frame"]
    picks = pd.DataFrame(rows, columns=columns)
    picks["name"] = [Capture.load(folder).names[i] for i in picks["frame"]]
    picks.to_parquet(folder / "selections.parquet")
    return folder


def targets_of(folder):
    return Split.load(folder / "split.parquet").targets


def outputs(folder):
    return [folder / "f.pdf", folder / "f.png"], folder / "f.csv"


def test_the_plan_keeps_horizontal_distances():
    capture = random_capture(12)
    places, up = plan_positions(capture), upwards(capture.world_to_camera)
    flat = capture.centers - np.outer(capture.centers @ up, up)
    for i in range(1, 12):
        expected = np.linalg.norm(flat[i] - flat[0])
        assert np.linalg.norm(places[i] - places[0]) == pytest.approx(expected)
    np.testing.assert_allclose(places.min(axis=0), -places.max(axis=0))


def test_the_fittest_so_far_need_not_have_the_highest_psnr():
    rows = {"generation": [0, 0, 1, 1], "psnr": [20.0, 22.0, 21.0, 25.0]}
    found = met_until(pd.DataFrame(rows | {"fitness": [0.1, 0.5, 0.7, 0.6]}))
    assert found["best"].tolist() == [20.0, 22.0, 21.0, 21.0]


def test_the_strongest_baseline_is_none_that_has_a_column_and_not_the_control():
    rows = [("uniform", 9, 30.0), ("fvs", 9, 20.0), ("dpp", 9, 21.0), ("fvs", 5, 40.0)]
    rows += [("untrained", 9, 35.0), ("nearest", 9, 36.0), ("dpp", 9, 22.0)]
    table = pd.DataFrame(rows, columns=["method", "k", "psnr"])
    assert resolved(["uniform", STRONGEST, "fsel"], table, 9) == ["uniform", "dpp", "fsel"]
    assert resolved([STRONGEST], table, 9) == ["uniform"]
    with pytest.raises(ValueError, match="at a budget of 7"):
        resolved([STRONGEST], table, 7)


@pytest.mark.parametrize("row", [0, -1])
@pytest.mark.parametrize("column", [0, -1])
def test_the_inset_lies_where_the_error_is_least(row, column):
    error = np.ones((30, 40))
    error[row, column] = 0
    x, y = _calmest(error)
    assert (x == 0, y == 0) == (column == 0, row == -1)


def test_shown_views_have_the_quality_that_an_evaluation_finds(scene, tmp_path):
    figures, numbers = outputs(tmp_path)
    paths = scene / "split.parquet", scene / "selections.parquet"
    settings = {"methods": ["all", "strongest"], "views": 2, "k": 8}
    evaluation = tmp_path / "evaluation.parquet"
    pd.DataFrame({"method": ["uniform"], "k": [8], "psnr": [20.0]}).to_parquet(evaluation)
    how = {"reconstruction": RECONSTRUCTION, "facts": FACTS}
    qualitative(scene, *paths, [evaluation], figures, numbers, **settings, **how)
    table, targets = pd.read_csv(numbers), targets_of(scene)
    reconstructor = reconstructor_of(Capture.load(scene), RECONSTRUCTION)
    evaluate = Evaluator.on_frames(reconstructor, targets)
    picked = pd.read_parquet(paths[1]).query("seed == 0")
    for method, part in table.groupby("method"):
        frames = picked[picked["method"] == method]["frame"].to_numpy()
        assert (part["k"] == len(frames)).all()
        selected = part[part["role"] == "selected"]
        assert selected["frame"].tolist() == frames.tolist()
        shown = part[part["role"] == "target"]
        assert shown["frame"].tolist() == targets.tolist()
        np.testing.assert_allclose(shown["psnr"], evaluate.measure(frames).scores[:, 0], atol=1e-5)
    assert all(path.stat().st_size > 1000 for path in figures)


def test_views_of_one_capture_are_rendered_from_the_others_by_name(scene, tmp_path):
    whole = Capture.load(scene)
    passes = replace(whole, sequences=("a",) * 20 + ("b",) * 20)
    rest = np.setdiff1d(np.arange(40), [0, 30])  # the larger capture lost two frames
    passes.subset(rest).save(tmp_path / "large")
    pd.DataFrame({"name": whole.names}).to_parquet(tmp_path / "frames.parquet")
    picked = {"b": [25, 31, 22, 39], "a": [1, 2, 3, 4]}
    rows = [(h, "fvs", 0, 4, i, whole.names[f]) for h, a in picked.items() for i, f in enumerate(a)]
    picks = pd.DataFrame(rows, columns=["held_out", "method", "seed", "k", "order", "name"])
    # the frames picked while the first sequence was held out are those of the second
    picks["held_out"] = picks["held_out"].map({"b": "a", "a": "b"})
    picks["draw"] = 0
    picks.to_parquet(tmp_path / "picks.parquet")
    measured = pd.DataFrame(
        {"held_out": ["a"] * 4, "draw": 0, "method": "fvs", "k": 4, "psnr": 20.0}
    )
    measured.assign(target=[3, 5, 3, 5]).to_parquet(tmp_path / "evaluation.parquet")
    figures, numbers = outputs(tmp_path)
    read = [tmp_path / f"{n}.parquet" for n in ("frames", "picks", "evaluation")]
    settings = {"views": 1, "k": 4, "reconstruction": RECONSTRUCTION, "facts": FACTS}
    real_world(
        tmp_path / "large", *read, figures, numbers, methods=["all", "strongest"], **settings
    )
    table = pd.read_csv(numbers)
    shown = table[table["role"] == "target"]
    assert shown["frame"].tolist() == [2, 4] * 2  # 3 and 5, frame 0 being gone
    selected = table[table["role"] == "selected"].groupby("method")["frame"].apply(list)
    assert selected["fvs"] == [24, 29, 21, 37]
    assert selected["all"] == list(range(19, 38))


def test_the_plans_show_the_fittest_labels_of_three_levels(scene, tmp_path):
    levels, picks = (25, 40, 60, 100), {}
    table = pd.read_parquet(scene / "split.parquet")
    splits = tmp_path / "splits.parquet"
    pd.concat([table.assign(coverage=c) for c in levels]).to_parquet(splits)
    subsets = pd.DataFrame({"generation": [0, 1], "psnr": [20.0, 21.0], "fitness": [0.0, 1.0]})
    labels = {c: tmp_path / f"p{c}.parquet" for c in levels}
    for c, path in labels.items():
        subsets.assign(psnr=subsets["psnr"] + c).to_parquet(path)
    rows = []
    for scene_name in ("here", "elsewhere"):
        for c in levels:
            for rank in (0, 1):
                picks[scene_name, c, rank] = [c % 7, 10 + rank, 20]
                rows.append((scene_name, c, rank, picks[scene_name, c, rank]))
    trajectories = tmp_path / "trajectories.parquet"
    columns = ["scene", "coverage", "rank", "picks"]
    pd.DataFrame(rows, columns=columns).to_parquet(trajectories)
    figures, numbers = outputs(tmp_path)
    drawn = {25: "here", 60: "elsewhere", 100: "here"}
    read = [scene] * 3, [splits] * 3, [labels[c] for c in drawn], trajectories
    settings = {"scenes": drawn, "facts": FACTS}
    pipeline_figure(*read, figures, numbers, **settings)
    found = pd.read_csv(numbers)
    assert found.query("panel == 'population'")["psnr"].tolist() == [120.0, 121.0]
    plans = found[found["panel"] == "plan"].groupby("coverage")["frame"].apply(list)
    assert plans.to_dict() == {c: picks[name, c, 0] for c, name in drawn.items()}
