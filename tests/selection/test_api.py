"""The library's face: `import fsel` is enough."""

import ast
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from own_python import printed
from selection_problems import random_weights
from small_captures import write_ring

import fsel
from fsel.captures import read
from fsel.captures.images import previews
from fsel.captures.images.previews import sharpness
from fsel.captures.lazy import open_capture
from fsel.selection import select as selection
from fsel.selection.request import method_of
from fsel.selectors.scorer import Network


@pytest.fixture
def folder(tmp_path):
    write_ring(tmp_path / "capture")
    return tmp_path / "capture"


def test_importing_costs_nothing_and_every_name_is_there():
    # nor may the command line import NumPy before it has set the number of threads
    script = "import fsel, fsel.cli, sys; print('numpy' in sys.modules)"
    assert printed(script) == "False\n"
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


def test_a_capture_in_memory_outlives_its_files(folder, tmp_path):
    gone = shutil.copytree(folder, tmp_path / "gone")
    capture = fsel.read_capture(gone, long_side=64)
    shutil.rmtree(gone)
    chosen = fsel.select(capture, 4, method="uniform")
    assert chosen.indices.tolist() == [0, 8, 15, 23]
    with pytest.raises(ValueError, match="Hint: fsel"):
        chosen.export(tmp_path / "out")


def test_seeds_matter_to_chance_which_has_no_scores(folder):
    capture = fsel.read_capture(folder, long_side=64)
    drawn = [fsel.select(capture, 6, method="random", seed=seed) for seed in (0, 0, 1)]
    assert drawn[0].names == drawn[1].names != drawn[2].names
    assert np.isnan(drawn[0].scores).all()


def test_methods_with_appearance_take_the_descriptors_given(folder):
    """All frames alike but for two: a determinantal process picks those and one of the others."""
    capture = fsel.read_capture(folder, long_side=64)
    given = np.zeros((len(capture), 3), np.float32)
    given[:, 0] = 1
    given[5], given[17] = [0, 1, 0], [0, 0, 1]
    picks = fsel.select(capture, 3, method="dpp", descriptors=given).indices
    assert {5, 17} < set(picks.tolist())


def test_images_are_not_opened_for_a_method_that_reads_none(folder, monkeypatch):
    capture = fsel.read_capture(folder, long_side=64)
    measured = []
    monkeypatch.setattr(
        selection, "measure_sharpness", lambda images: measured.append(len(images)) or np.ones(24)
    )
    first = fsel.select(capture, 6, patience=0, sharpness=np.zeros(24))
    fsel.select(capture, 6, method="uniform")
    assert not measured
    assert fsel.select(capture, 6, patience=0).names == first.names
    fsel.select(capture, 6, method="sharpest")
    assert measured == [24]


def test_reduced_decoding_ranks_images_as_full_decoding_does(tmp_path):
    rng = np.random.default_rng(0)
    noise = cv2.resize(rng.integers(0, 255, (270, 480), dtype=np.uint8), (1920, 1080))
    files = []
    for number, blur in enumerate((9, 0, 25, 4)):
        image = cv2.GaussianBlur(noise, (0, 0), blur) if blur else noise
        files.append(tmp_path / f"{number}.jpg")
        cv2.imwrite(str(files[-1]), image)
    measured = previews.sharpness_among(files, 1920)(range(len(files)))
    whole = sharpness(np.stack([cv2.imread(str(file)) for file in files]))
    np.testing.assert_array_equal(np.argsort(measured), np.argsort(whole))


@pytest.mark.parametrize(("width", "side"), [(1920, 480), (1919, 959), (500, 500), (4000, 500)])
def test_a_reduced_image_keeps_the_side_that_is_needed(width, side, tmp_path, monkeypatch):
    shapes = []
    monkeypatch.setattr(
        previews, "variance_of_laplacian", lambda grey: shapes.append(grey.shape) or 0.0
    )
    cv2.imwrite(str(tmp_path / "a.jpg"), np.zeros((width // 2, width, 3), np.uint8))
    previews.sharpness_among([tmp_path / "a.jpg"], width)([0])
    assert shapes[0][1] >= min(width, previews.SHARPNESS_SIDE)
    assert shapes[0][1] < max(2 * previews.SHARPNESS_SIDE + 8, width // 8 + 8)
    (small,) = previews.thumbnails([tmp_path / "a.jpg"], width, side)
    assert max(cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR).shape) == side


def seen_by(points, frame):
    return np.sort(points.xyz[points.track_point[points.track_frame == frame]], axis=0)


def test_an_opened_capture_loads_the_frames_asked_for(folder):
    opened = open_capture(folder, long_side=64)
    whole = fsel.read_capture(folder, long_side=64)
    frames = np.array([7, 3, 12])
    part = opened.loaded(frames)
    assert part.names == tuple(whole.names[i] for i in frames)
    np.testing.assert_array_equal(part.images, whole.images[frames])
    np.testing.assert_array_equal(part.world_to_camera, whole.world_to_camera[frames])
    for row, frame in enumerate(frames):
        np.testing.assert_array_equal(seen_by(part.points, row), seen_by(whole.points, frame))


def test_points_of_a_sample_number_the_frames_of_the_capture(folder, monkeypatch):
    monkeypatch.setattr(read, "SAMPLE", 4)
    opened = open_capture(folder, long_side=64)
    assert opened.capture.points is None
    points, whole = opened.with_points().points, fsel.read_capture(folder, long_side=64).points
    drawn = [0, 8, 15, 23]
    assert sorted(set(points.track_frame)) == drawn
    for frame in drawn:
        np.testing.assert_array_equal(seen_by(points, frame), seen_by(whole, frame))


@pytest.mark.parametrize(
    ("provenance", "method", "said"),
    [
        ({}, None, "mine.safetensors: scorer of the policy"),
        ({"policy": "best", "made by": "a test"}, None, "'best'"),
        ({"policy": "fsel", "made by": "a test"}, None, "kind Linear, not Network"),
        ({"policy": "less_is_more", "made by": "a test"}, "fsel", "the policy 'less_is_more', not"),
    ],
)
def test_weights_of_another_policy_are_refused(provenance, method, said, tmp_path):
    Network(random_weights(0), provenance).save(tmp_path / "mine.safetensors")
    with pytest.raises(ValueError, match=said):
        method_of(method, tmp_path / "mine.safetensors")


def test_dropping_a_pick_changes_that_pick_alone(ring, tmp_path):
    """By the nearest frame on the ring; a kept frame takes the place instead where there is one."""
    chosen = fsel.select(ring, 6, patience=0)
    lost = int(chosen.indices[1])
    (tmp_path / "frames.txt").write_text("\n".join(chosen.names))
    always, never = [str(tmp_path / "frames.txt")], [chosen.names[1]]
    picks = set(chosen.indices.tolist()) - {lost}
    asked = {"never": never, "patience": 0}
    (other,) = set(fsel.select(ring, 6, always=always, **asked).indices.tolist()) - picks
    assert other in {(lost - 1) % 24, (lost + 1) % 24}
    kept = next(i for i in range(24) if i not in picks | {lost, other})
    wanted = [*always, f"frame_{kept:03d}.jpg"]
    assert set(fsel.select(ring, 6, always=wanted, **asked).indices) == picks | {kept}
    assert set(fsel.select(ring, 7, always=wanted, patience=0).indices) == picks | {lost, kept}
