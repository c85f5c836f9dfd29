"""Programs of one's own: what they are given, what is read back, how they may end."""

import json
import os
import resource
import sys
import time

import cv2
import numpy as np
import pycolmap
import pytest
from selection_problems import around, pointed
from small_captures import ring

from fsel.core.programs.outcome import Unfinished
from fsel.evaluation.evaluator import Evaluator
from fsel.reconstruct import check_needs
from fsel.reconstruct.external import External

SIZE = (24, 18)
# writes the mean image of the selected frames for every target
MEAN = """
import json, sys
import cv2, numpy as np
frames = json.load(open("transforms.json"))["frames"]
mean = np.mean([cv2.imread(frame["file_path"]) for frame in frames], axis=0)
for target in json.load(open("targets.json"))["frames"]:
    cv2.imwrite("renderings/" + target["file"], mean.round().astype(np.uint8))
"""
FRAMES = np.array([5, 0, 3])
TARGETS = np.array([1, 6])


@pytest.fixture
def capture():
    return pointed(around(ring(8), size=SIZE))


def program(text, *arguments):
    """A command that runs a Python program given as text."""
    return [sys.executable, "-c", text, *arguments]


def unfinished(capture, text, **settings):
    """How a rendering program ends."""
    with pytest.raises(Unfinished) as failure:
        External(capture, render=program(text), **settings).fit(FRAMES).render(
            capture.view(TARGETS)
        )
    return failure.value


def test_images_come_back_as_the_program_left_them(capture):
    model = External(capture, render=program(MEAN)).fit(FRAMES)
    images = model.render(capture.view(TARGETS))
    mean = np.asarray(capture.images, np.float64)[[0, 3, 5]].mean(axis=0).round() / 255
    assert images.dtype == np.float32
    np.testing.assert_allclose(images, np.stack([mean, mean]), atol=1e-6)
    assert (model.device, model.primitives, model.seconds) == ("cpu", 0, 0)
    # a program that starts holds what this process holds, until it is replaced
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    assert 1e6 < model.peak_bytes <= max(1e9, own)
    folder = model.folder
    assert folder.is_dir()
    del model
    assert not folder.exists()


def test_the_folder_holds_the_selected_frames_alone(capture, tmp_path):
    model = External(capture, render=program(MEAN), workspace=str(tmp_path)).fit(FRAMES)
    model.render(capture.view(TARGETS))
    folder = model.folder
    del model
    assert sorted(path.name for path in folder.iterdir()) == [
        *("images", "log.txt", "masks", "renderings", "sparse", "sparse_pc.ply"),
        *("targets.json", "transforms.json"),
    ]
    names = [f"{row:06d}.png" for row in range(3)]
    assert sorted(os.listdir(folder / "images")) == names == sorted(os.listdir(folder / "masks"))
    for name, frame in zip(names, [0, 3, 5], strict=True):
        image = cv2.imread(str(folder / "images" / name))[:, :, ::-1]
        np.testing.assert_array_equal(image, capture.images[frame])
        mask = cv2.imread(str(folder / "masks" / name), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(mask == 255, capture.masks[frame])


def test_cameras_and_points_say_the_same_in_both_forms(capture, tmp_path):
    model = External(capture, render=program(MEAN), workspace=str(tmp_path)).fit(FRAMES)
    model.render(capture.view(TARGETS))
    found = pycolmap.Reconstruction(str(model.folder / "sparse" / "0"))
    # points 0 and 3 alone are seen by two of the frames 0, 3, 5; 1 by one, 2 by one
    kept = sorted(tuple(point.xyz) for point in found.points3D.values())
    assert kept == sorted(tuple(xyz) for xyz in capture.points.xyz[[0, 3]])
    assert found.compute_mean_reprojection_error() < 1e-9
    content = json.loads((model.folder / "transforms.json").read_text())
    for row, frame in enumerate([0, 3, 5]):
        pose = found.images[row + 1].cam_from_world().matrix()
        np.testing.assert_allclose(pose, capture.world_to_camera[frame], atol=1e-12)
        matrix = np.array(content["frames"][row]["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])
        np.testing.assert_allclose(np.linalg.inv(matrix)[:3], pose, atol=1e-12)
    targets = json.loads((model.folder / "targets.json").read_text())["frames"]
    for target, frame in zip(targets, TARGETS, strict=True):
        pose = np.array(target["world_to_camera"])[:3]
        np.testing.assert_array_equal(pose, capture.world_to_camera[frame])
        stated = [target[key] for key in ("fl_x", "fl_y", "cx", "cy")]
        assert stated == capture.intrinsics[frame].tolist()
        assert (target["w"], target["h"]) == SIZE


@pytest.mark.parametrize(
    ("text", "outcome", "said"),
    [
        ("print('worked until here'); 1 / 0", "failed", "exit code 1\nworked until here\nTrace"),
        ("raise MemoryError", "out of memory", "exit code 1, out of memory"),
        ("print('CUDA out of memory.'); exit(3)", "out of memory", "exit code 3"),
        ("import os, signal; os.kill(os.getpid(), 9)", "out of memory", "was killed"),
        ("pass", "no image", "000000.png is missing"),
        ("open('renderings/000000.png', 'w').write('no')", "no image", "000000.png is no image"),
        (MEAN.replace("mean.round()", "mean[:9].round()"), "wrong size", r"shape (9, 24, 3)"),
        (MEAN.replace("uint8", "uint16"), "wrong size", "type uint16"),
    ],
)
def test_how_a_program_may_end(capture, text, outcome, said):
    ended = unfinished(capture, text)
    assert ended.outcome == outcome
    assert said in str(ended)


def test_a_program_that_takes_too_long_is_ended_with_its_children(capture, tmp_path):
    child = f"import time; time.sleep(2); open({str(tmp_path / 'late')!r}, 'w')"
    text = (
        "import subprocess, sys, time; print('begun', flush=True); "
        f"subprocess.Popen([sys.executable, '-c', {child!r}]); time.sleep(60)"
    )
    started = time.monotonic()
    ended = unfinished(capture, text, timeout=1)
    assert ended.outcome == "timeout"
    assert ended.log == "begun"
    assert time.monotonic() - started < 20
    time.sleep(1.5)
    assert not (tmp_path / "late").exists()


def test_a_fit_that_fails_leaves_nothing_behind(capture, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    with pytest.raises(Unfinished, match="exit code 2"):
        External(capture, render=["true"], fit=program("exit(2)")).fit(FRAMES)
    assert list(tmp_path.iterdir()) == []


def test_a_program_has_its_own_environment(capture, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/this/process")
    (tmp_path / "bin").mkdir()
    tool = tmp_path / "bin" / "tool"
    tool.write_text(
        '#!/bin/sh\necho "path=$PYTHONPATH venv=$VIRTUAL_ENV mark=$MARK all=$*"\nexit 1\n'
    )
    tool.chmod(0o755)
    settings = {"venv": str(tmp_path), "prefix": ["env", "MARK=a b"]}
    with pytest.raises(Unfinished) as failure:
        External(capture, render=["tool", "{folder}", "$HOME; *"], **settings).fit(FRAMES).render(
            capture.view(TARGETS)
        )
    first = failure.value.log.splitlines()[0]
    assert first.startswith(f"path= venv={tmp_path} mark=a b all=/")
    assert first.endswith(" $HOME; *")


def test_the_evaluation_goes_on_and_a_search_stops(capture):
    reconstructor = External(capture, render=program("exit(7)"))
    evaluator = Evaluator.on_frames(reconstructor, TARGETS)
    found = evaluator.measure(FRAMES)
    assert np.isnan(found.scores).all()
    assert (found.outcome, found.device) == ("failed", "")
    with pytest.raises(Unfinished, match="exit code 7"):
        evaluator(FRAMES)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({}, "render must be a command, a list of strings, got none"),
        ({"render": "run me"}, "render must be a list of strings, got 'run me'"),
        ({"render": ["true", "{targets}"]}, r"render has {targets} in '{targets}'; allowed: {fold"),
        ({"render": ["true"], "timeout": 0}, "timeout must be seconds above zero, got 0"),
        ({"render": ["no_such_program"]}, "no program 'no_such_program' in /"),
        ({"render": ["true"], "venv": "/no/such"}, "venv: no virtual environment in /no/such"),
        ({"render": ["true"], "fit": []}, "fit must be a command or null, got an empty list"),
    ],
)
def test_what_cannot_work_is_refused_before_work(settings, said):
    with pytest.raises(ValueError, match=rf"reconstructor 'external': {said}"):
        check_needs({"name": "external", "settings": settings})
