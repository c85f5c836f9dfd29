"""The library's face: `import fsel` is enough."""

import ast
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from safetensors.numpy import save_file
from selection_problems import random_problem
from small_captures import write_ring

import fsel
from fsel.captures import read
from fsel.captures.images import previews
from fsel.captures.images.previews import sharpness
from fsel.captures.lazy import open_capture
from fsel.experiments.studies.hard_cases.worlds import random_weights
from fsel.selection import budget
from fsel.selection import select as selection
from fsel.selection.request import method_of
from fsel.selection.targets import targets_of
from fsel.selectors import pretrained
from fsel.selectors.scorer import Network


@pytest.fixture
def folder(tmp_path):
    write_ring(tmp_path / "capture")
    return tmp_path / "capture"


def test_importing_costs_nothing_and_every_name_is_there():
    # nor may the command line import NumPy before it has set the number of threads
    script = "import fsel, fsel.cli, sys; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0
    for name in fsel.__all__:
        assert getattr(fsel, name) is not None
    unknown = "selekt"
    with pytest.raises(AttributeError, match="no attribute 'selekt'"):
        getattr(fsel, unknown)


def test_type_checkers_see_every_name_where_it_lives():
    tree = ast.parse(Path(fsel.__file__).read_text())
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    stated = {
        alias.asname or alias.name: line.module
        for line in guarded.body
        for alias in line.names
        if line.module != "typing"
    }
    assert stated == fsel._HOMES
    assert sorted(stated) == sorted(fsel.__all__)


def test_from_a_folder_to_metrics_in_four_calls(folder, tmp_path):
    capture = fsel.read_capture(folder, long_side=64)
    chosen = fsel.select(capture, 8, targets="every:6")
    assert chosen.names == tuple(capture.names[i] for i in chosen.indices)
    assert not set(chosen.indices) & {0, 6, 12, 18}
    assert np.isfinite(chosen.scores).all()
    model = fsel.fit(capture, chosen.indices)
    scores = fsel.evaluate(capture, model, np.array([0, 6, 12, 18]))
    assert {name: values.shape for name, values in scores.items()} == {
        "psnr": (4,),
        "ssim": (4,),
        "gmsd": (4,),
    }
    model.export_ply(tmp_path / "scene.ply")
    assert (tmp_path / "scene.ply").stat().st_size > 100


def test_budgets_nest_and_seeds_matter_only_to_chance(folder):
    capture = fsel.read_capture(folder, long_side=64)
    six = fsel.select(capture, 6, seed=1, patience=0)
    nine = fsel.select(capture, 9, seed=2, patience=0)
    np.testing.assert_array_equal(six.indices, nine.indices[:6])
    drawn = [tuple(fsel.select(capture, 6, method="random", seed=s).indices) for s in (0, 0, 1)]
    assert drawn[0] == drawn[1] != drawn[2]
    assert np.isnan(fsel.select(capture, 6, method="random").scores).all()


def test_auto_for_a_whole_capture_is_the_number_of_picks_for_views_on_its_path():
    """And the picks are those of the request with that number, off the path too."""
    problem = random_problem(90, 3)
    capture = replace(problem.capture, names=tuple(f"{i:03d}.jpg" for i in range(90)))
    chosen = fsel.select(capture, "auto")
    along = targets_of(capture, None).views.subset(np.round(np.linspace(0, 59, 30)).astype(int))
    pool, views = np.arange(90), replace(problem, targets=along, candidates=np.arange(90))
    views = replace(views, targets_unknown=True, proxies=np.arange(30))
    order = pretrained.method().ranked(views, 90)[0]
    shift, worth = budget.view_shift(capture, pool, along), budget.shipped_worth()
    expected = budget.find(shift[order], budget.Auto(), capture.size, worth).frames
    assert chosen.budget.frames == len(chosen.names) == expected
    assert chosen.names == fsel.select(capture, expected, patience=0).names


def test_methods_with_appearance_take_the_descriptors_given(folder):
    """All frames alike but for two: a determinantal process picks those and one of the others."""
    capture = fsel.read_capture(folder, long_side=64)
    given = np.zeros((len(capture), 3), np.float32)
    given[:, 0] = 1
    given[5], given[17] = [0, 1, 0], [0, 0, 1]
    picks = fsel.select(capture, 3, method="dpp", descriptors=given).indices
    assert {5, 17} < set(picks.tolist())


def test_an_unknown_reconstructor_is_refused(folder):
    with pytest.raises(ValueError, match="allowed: splats"):
        fsel.fit(fsel.read_capture(folder), [0, 1], "nerf")


def test_the_shipped_rule_is_four_coefficients():
    text = (Path(pretrained.__file__).parent / "weights" / "fsel.json").read_text()
    assert json.loads(text)["coefficients"] == {
        "d_min_s": 0.4,
        "gamma_min_s": 0.2,
        "phi_nov": 0.35,
        "target_gain": 150.0,
    }
    assert pretrained.method().scorer.provenance["policy"] == "fsel"


def test_images_are_not_opened_for_a_method_that_reads_none(folder, monkeypatch):
    capture = fsel.read_capture(folder, long_side=64)
    measured = []

    def measure(images):
        measured.append(len(images))
        return np.ones(len(images))

    monkeypatch.setattr(selection, "measure_sharpness", measure)
    first = fsel.select(capture, 6, patience=0, sharpness=np.zeros(24))
    fsel.select(capture, 6, method="uniform")
    assert not measured
    assert fsel.select(capture, 6, patience=0).names == first.names
    fsel.select(capture, 6, method="sharpest")
    assert measured == [24]
    assert method_of("fsel").reads == ()
    assert method_of("dpp").reads == ("appearance",)


def test_reduced_decoding_ranks_images_as_full_decoding_does(tmp_path):
    rng = np.random.default_rng(0)
    noise = cv2.resize(rng.integers(0, 255, (270, 480), dtype=np.uint8), (1920, 1080))
    files = []
    for number, blur in enumerate((9, 0, 25, 4)):
        image = cv2.GaussianBlur(noise, (0, 0), blur) if blur else noise
        files.append(tmp_path / f"{number}.jpg")
        cv2.imwrite(str(files[-1]), image)
    measured = previews.sharpness_of_files(files, 1920)
    whole = sharpness(np.stack([cv2.imread(str(file)) for file in files]))
    np.testing.assert_array_equal(np.argsort(measured), np.argsort(whole))


@pytest.mark.parametrize(("width", "side"), [(1920, 480), (1919, 959), (500, 500), (4000, 500)])
def test_a_reduced_image_keeps_the_side_that_is_needed(width, side, tmp_path, monkeypatch):
    shapes = []
    monkeypatch.setattr(
        previews, "variance_of_laplacian", lambda grey: shapes.append(grey.shape) or 0.0
    )
    cv2.imwrite(str(tmp_path / "a.jpg"), np.zeros((width // 2, width, 3), np.uint8))
    previews.sharpness_of_files([tmp_path / "a.jpg"], width)
    assert shapes[0][1] >= min(width, previews.SHARPNESS_SIDE)
    assert shapes[0][1] < max(2 * previews.SHARPNESS_SIDE + 8, width // 8 + 8)
    (small,) = previews.thumbnails([tmp_path / "a.jpg"], width, side)
    assert max(cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR).shape) == side


def test_an_opened_capture_loads_the_frames_asked_for(folder):
    opened = open_capture(folder, long_side=64)
    whole = fsel.read_capture(folder, long_side=64)
    frames = np.array([7, 3, 12])
    part = opened.loaded(frames)
    assert part.names == tuple(whole.names[i] for i in frames)
    np.testing.assert_array_equal(part.images, whole.images[frames])
    np.testing.assert_array_equal(part.world_to_camera, whole.world_to_camera[frames])
    for row, frame in enumerate(frames):
        expected = whole.points.xyz[whole.points.track_point[whole.points.track_frame == frame]]
        xyz = part.points.xyz[part.points.track_point[part.points.track_frame == row]]
        np.testing.assert_array_equal(np.sort(xyz, axis=0), np.sort(expected, axis=0))


def test_points_of_a_sample_number_the_frames_of_the_capture(folder, monkeypatch):
    monkeypatch.setattr(read, "SAMPLE", 4)
    opened = open_capture(folder, long_side=64)
    assert opened.capture.points is None
    points, whole = opened.with_points().points, fsel.read_capture(folder, long_side=64).points
    drawn = [0, 8, 15, 23]
    assert sorted(set(points.track_frame)) == drawn
    for frame in drawn:
        expected = whole.xyz[whole.track_point[whole.track_frame == frame]]
        xyz = points.xyz[points.track_point[points.track_frame == frame]]
        np.testing.assert_array_equal(np.sort(xyz, axis=0), np.sort(expected, axis=0))


def test_weights_of_one_s_own_take_the_place_of_those_that_come_with_the_package(folder, tmp_path):
    capture = fsel.read_capture(folder, long_side=64)
    scorer = Network(
        random_weights(5), {"policy": "less_is_more_no_appearance", "made by": "a test"}
    )
    scorer.save(tmp_path / "mine.safetensors")
    mine = fsel.select(capture, 6, targets="every:6", weights=tmp_path / "mine.safetensors")
    named = fsel.select(
        capture, 6, "every:6", "less_is_more_no_appearance", weights=tmp_path / "mine.safetensors"
    )
    shipped = fsel.select(capture, 6, targets="every:6", method="less_is_more_no_appearance")
    assert mine.names == named.names
    np.testing.assert_array_equal(mine.scores, named.scores)
    assert not np.array_equal(mine.scores, shipped.scores)


@pytest.mark.parametrize(
    ("provenance", "changes", "method", "said"),
    [
        ({}, {}, None, "mine.safetensors: scorer of the policy"),
        ({"policy": "best", "made by": "a test"}, {}, None, "'best'"),
        ({"policy": "fsel", "made by": "a test"}, {}, None, "kind Linear, not Network"),
        (
            {"policy": "less_is_more", "made by": "a test"},
            {},
            "fsel",
            "made for the policy 'less_is_more', not",
        ),
        (
            {"policy": "less_is_more", "made by": "a test"},
            {"layer1.bias": np.full(64, np.nan, np.float32)},
            None,
            "layer1.bias are not finite",
        ),
    ],
)
def test_weights_that_are_no_scorer_are_refused(
    provenance, changes, method, said, folder, tmp_path
):
    path = tmp_path / "mine.safetensors"
    save_file(random_weights(0) | changes, path, metadata={"provenance": json.dumps(provenance)})
    with pytest.raises(ValueError, match=said):
        fsel.select(fsel.read_capture(folder), 6, method=method, weights=path)
