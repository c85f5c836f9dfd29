"""Workers: what they are handed, what comes back, and how they may fail."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from selection_problems import around, pointed
from small_captures import ring
from worker_checks import check_worker

from fsel.core.programs import Unfinished, tail
from fsel.evaluation.evaluator import Evaluator
from fsel.reconstruct import check_needs
from fsel.reconstruct.external import External, write_files
from fsel.reconstruct.external.worker import close_all
from fsel.reconstruct.selected import restricted

SIZE = (24, 18)
FRAMES, TARGETS = np.array([5, 0, 3]), np.array([1, 6])
# every view is the mean image of the selected frames; WRONG runs before each fit
MEAN = """
import os, sys, time
import numpy as np
from fsel_worker import serve

fits = []

def fit(subset):
    fits.append(1)
    WRONG
    return subset.images.mean(axis=0) / 255

serve(fit, lambda model, views: np.stack([model] * len(views)), name="mean", version="1")
"""
KEEP = "global last; last = [subset.images.mean(axis=0) / 255]"
# faults that happen once, in the first start of the worker: it leaves a mark
ONCE = "if not os.path.exists('{mark}'): open('{mark}', 'w').close(); {fault}"


@pytest.fixture
def capture():
    return pointed(around(ring(8), size=SIZE))


@pytest.fixture(autouse=True)
def ended():
    yield
    close_all()


def worker(text, **settings):
    return {"serve": [sys.executable, "-c", text], "timeout": 600, **settings}


def mean(wrong="pass", **settings):
    return worker(MEAN.replace("WRONG", wrong), **settings)


def rendered(capture, settings, frames=FRAMES):
    return External(capture, **settings).fit(frames).render(capture.view(TARGETS))


def expected(capture, frames=FRAMES):
    image = np.asarray(capture.images)[frames].mean(axis=0) / 255
    return np.stack([image] * len(TARGETS)).astype(np.float32)


def test_a_worker_is_handed_the_selected_frames_and_points_that_two_of_them_see(capture, tmp_path):
    text = f"""
import pickle
from fsel_worker import serve

def fit(subset):
    pickle.dump(vars(subset), open({str(tmp_path / "seen")!r}, "wb"))
    raise ValueError("seen enough")

serve(fit, None, needs=["points"])
"""
    with pytest.raises(Unfinished, match="failed to fit: ValueError: seen enough") as failure:
        rendered(capture, worker(text))
    assert "Traceback" in failure.value.log
    seen = np.load(tmp_path / "seen", allow_pickle=True)
    order = [0, 3, 5]
    assert seen["frames"].tolist() == order
    for name in ("images", "masks", "world_to_camera", "intrinsics"):
        np.testing.assert_array_equal(seen[name], getattr(capture, name)[order])
    np.testing.assert_array_equal(seen["xyz"], capture.points.xyz[[0, 3]])
    tracks = sorted(zip(seen["track_point"].tolist(), seen["track_frame"].tolist(), strict=True))
    assert tracks == [(0, 0), (0, 1), (1, 0), (1, 2)]


def test_a_worker_that_reads_files_has_the_images(capture):
    text = """
import json, os
import cv2, numpy as np
from fsel_worker import serve

def fit(subset):
    frames = json.load(open(os.path.join(subset.folder, "transforms.json")))["frames"]
    paths = [os.path.join(subset.folder, frame["file_path"]) for frame in frames]
    return np.mean([cv2.imread(path)[:, :, ::-1] for path in paths], axis=0).round()

def render(model, views):
    return np.stack([model.astype(np.uint8)] * len(views))

serve(fit, render, needs=["files"], pixels="uint8")
"""
    reconstructor = External(capture, **worker(text))
    for frames in (FRAMES, np.array([1, 2])):
        images = reconstructor.fit(frames).render(capture.view(TARGETS))
        wanted = (expected(capture, frames).astype(np.float64) * 255).round() / 255
        np.testing.assert_allclose(images, wanted, atol=1.01 / 255)


def test_files_hold_the_selected_frames_in_every_form(capture, tmp_path):
    write_files(tmp_path, restricted(capture, np.array([0, 3, 5])))
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *("images", "masks", "sparse", "sparse_pc.ply", "transforms.json")
    ]
    found = pycolmap.Reconstruction(str(tmp_path / "sparse" / "0"))
    # points 0 and 3 alone are seen by two of the frames 0, 3, 5; none by both 2 and 4
    assert len(restricted(capture, np.array([2, 4])).points.xyz) == 0
    kept = sorted(tuple(point.xyz) for point in found.points3D.values())
    assert kept == sorted(tuple(xyz) for xyz in capture.points.xyz[[0, 3]])
    assert found.compute_mean_reprojection_error() < 1e-9
    content = json.loads((tmp_path / "transforms.json").read_text())
    stated = [content | frame for frame in content["frames"]]
    assert len(stated) == len(os.listdir(tmp_path / "images")) == 3
    for row, frame in enumerate([0, 3, 5]):
        image = cv2.imread(str(tmp_path / stated[row]["file_path"]))[:, :, ::-1]
        np.testing.assert_array_equal(image, capture.images[frame])
        mask = cv2.imread(str(tmp_path / stated[row]["mask_path"]), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(mask == 255, capture.masks[frame])
        pose = found.images[row + 1].cam_from_world().matrix()
        np.testing.assert_allclose(pose, capture.world_to_camera[frame], atol=1e-12)
        matrix = np.array(stated[row]["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])
        np.testing.assert_allclose(np.linalg.inv(matrix)[:3], pose, atol=1e-12)
        lens = [stated[row][key] for key in ("fl_x", "fl_y", "cx", "cy")]
        assert lens == capture.intrinsics[frame].tolist()


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("print('worked until here', file=sys.stderr); os.kill(os.getpid(), 11)", "exit code -11"),
        ("os.kill(os.getpid(), 9)", "memory"),
        ("time.sleep(60)", "took longer than 5 s for 'fit'"),
        ("os.write(3, b'loading 100%\\\\n')", "b'loading 100%"),
    ],
)
def test_a_worker_that_is_lost_is_started_again_once(capture, tmp_path, caplog, fault, said):
    settings = mean(ONCE.format(mark=tmp_path / "mark", fault=fault), timeout=5)
    np.testing.assert_allclose(rendered(capture, settings), expected(capture), atol=1e-6)
    assert said in caplog.text
    assert "worker started again, once" in caplog.text


@pytest.mark.parametrize(
    ("fault", "outcome", "said"),
    [
        ("print('begun', file=sys.stderr); os._exit(3)", "failed", "exit code 3\nbegun"),
        ("print('CUDA out of memory.', flush=True); os._exit(1)", "out of memory", "exit code 1"),
        ("time.sleep(60)", "timeout", "took longer than 5 s"),
        ("raise MemoryError('no room')", "out of memory", "MemoryError: no room"),
        ("raise RuntimeError('CUDA out of memory. Tried')", "out of memory", "Tried"),
    ],
)
def test_a_subset_that_fails_is_reported_and_the_next_is_measured(
    capture, caplog, fault, outcome, said
):
    settings = mean(f"if 5 in subset.frames: {fault}", timeout=5)
    reconstructor = External(capture, **settings)
    evaluator = Evaluator.on_frames(reconstructor, TARGETS)
    assert evaluator.measure(np.array([3, 4])).outcome == ""
    process = reconstructor.worker._process
    found = evaluator.measure(FRAMES)
    assert np.isnan(found.scores).all()
    assert found.outcome == outcome
    assert evaluator.measure(np.array([2, 4])).outcome == ""
    # an error that is answered does not end the worker
    assert (reconstructor.worker._process is process) == fault.startswith("raise")
    assert said in caplog.text


def test_captures_share_a_worker_which_fits_again_what_it_lost(capture):
    other = replace(capture, images=255 - np.asarray(capture.images))
    one, two = External(capture, **mean()), External(other, **mean())
    assert one.worker is two.worker
    models = [one.fit(FRAMES), two.fit(FRAMES), one.fit(FRAMES)]
    for model, own in zip(models, (capture, other, capture), strict=True):
        images = model.render(own.view(TARGETS))
        assert images.dtype == np.float32
        np.testing.assert_allclose(images, expected(own), atol=1e-6)
    one.worker.stop()
    np.testing.assert_allclose(models[1].render(other.view(TARGETS)), expected(other), atol=1e-6)
    assert (models[0].device, models[0].primitives) == ("cpu", 0)
    assert models[0].seconds > 0


def hello(text):
    return f"input(); print({text!r}); input()"


def raw(answer, more=""):
    """A program that answers a fit by itself, and may say more."""
    return f"""
import json, sys, time
stated = {{"protocol": 2, "name": "raw", "version": "", "device": "cpu", "needs": []}}
for line in sys.stdin:
    fit = json.loads(line)["do"] == "fit"
    stated.update(ok=True, pixels="float32")
    print(json.dumps({answer} if fit else stated), flush=True)
    {more}
"""


def served(call):
    return f"import numpy as np; from fsel_worker import serve; serve({call})"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (hello('{"ok": true, "protocol": 1}'), "stated .*1}; allowed: protocol 2"),
        (hello('{"ok": true, "protocol": 2, "name": 5}'), "stated .*5}; allowed"),
        (hello("Loading weights"), "b'Loading weights"),
        (hello('["ok"]'), r'\["ok"\]'),
        (raw("{'ok': True, 'seconds': -1}"), "answered a fit with seconds -1"),
        (raw("{'ok': True, 'bytes': 'many'}"), "answered a fit with bytes 'many'"),
        (raw("{'error': 'no'}"), "answer: b"),
        (raw("{'ok': False, 'error': 'no'}"), "failed to fit: no"),
        (raw("{'ok': True}", "print('{}', flush=True); time.sleep(0.2)"), "answer: b"),
        (served("None, None, needs=['depth']"), "stated .*depth"),
        (served("None, None, pixels='float64'"), "stated .*float64"),
        (served("id, lambda m, v: np.ones((1, 2, 3))"), r"render returned shape \(1, 2, 3\)"),
        (served("id, lambda m, v: np.full((2, 18, 24, 3), np.nan)"), "target 0 of 2: nothing"),
    ],
)
def test_what_a_worker_says_wrong_is_refused(capture, text, said):
    with pytest.raises(Unfinished, match=said):
        rendered(capture, worker(text))


def test_what_a_worker_prints_is_no_answer(capture):
    text = MEAN.replace("fits = []", "fits = []; print('loading', flush=True)")
    text = text.replace("WRONG", "print('step 1'); os.system('echo from a child')")
    reconstructor = External(capture, **worker(text))
    model = reconstructor.fit(FRAMES)
    np.testing.assert_allclose(model.render(capture.view(TARGETS)), expected(capture), atol=1e-6)
    assert "from a child" in tail(reconstructor.worker.folder)


def test_a_good_worker_passes_the_checks(monkeypatch):
    check_worker(monkeypatch, mean()["serve"])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"[model] * len(views)": "[2 * model] * len(views)"}, "values above 1"),
        ({"[model] * len(views)": "[model / len(views)] * len(views)"}, "a view alone"),
        ({"[model] * len(views)": "[last[0]] * len(views)", "WRONG": KEEP}, "after another fit"),
        ({'version="1")': 'version="1"); sys.exit(4)'}, "with its input"),
    ],
)
def test_each_fault_of_a_worker_is_found(monkeypatch, wrong, said):
    text = MEAN
    for good, bad in wrong.items():
        text = text.replace(good, bad)
    with pytest.raises(AssertionError, match=said):
        check_worker(monkeypatch, worker(text.replace("WRONG", "pass"))["serve"])


PARENT = """
import sys
import numpy as np
sys.path[:0] = {path!r}
from test_worker import External, mean
import test_worker
capture = test_worker.capture.__wrapped__()
made = External(capture, **mean("time.sleep(6000) if len(fits) > 1 else None"))
made.fit(np.array([1, 2]))
print(made.worker._process.pid, flush=True)
made.fit(np.array([2, 3]))
"""


def test_a_worker_ends_with_a_process_that_was_killed(tmp_path):
    here = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]
    text = PARENT.format(path=here)
    parent = subprocess.Popen(
        [sys.executable, "-c", text],
        stdout=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    with parent:
        number = int(parent.stdout.readline())
        parent.send_signal(signal.SIGKILL)
    turns = iter(range(3000))
    while Path(f"/proc/{number}").exists() and next(turns, None) is not None:
        time.sleep(0.1)
    assert not Path(f"/proc/{number}").exists()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"serve": ["no_such_program"]}, "no program 'no_such_program' in /"),
        ({}, "serve must be the command of a worker"),
        ({"serve": ["true", "{targets}"]}, r"serve has {targets} in '{targets}'"),
        ({"serve": ["true"], "timeout": 0}, "timeout must be seconds above zero, got 0"),
        ({"serve": ["true"], "venv": "/no/such"}, "venv: no virtual environment in /no/such"),
        ({"serve": "mine.py"}, "serve must be a list of strings, got 'mine.py'"),
    ],
)
def test_what_cannot_work_is_refused_before_work(settings, said):
    with pytest.raises(ValueError, match=rf"reconstructor 'external': {said}"):
        check_needs({"name": "external", "settings": settings})
