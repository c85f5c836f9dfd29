"""`fsel select`: what it refuses, and what it leaves behind when it is cut off."""

import errno
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from small_captures import camera_path, record_of, ring, select, write_ring

from fsel.selection.export import placing, subset


def no_poses(folder, tmp_path):
    for file in (folder / "sparse" / "0").iterdir():
        file.unlink()
    return []


def two_frames(folder, tmp_path):
    for path in (folder / "sparse" / "0", folder / "images"):
        for file in path.iterdir():
            file.unlink()
        path.rmdir()
    (folder / "sparse").rmdir()
    write_ring(folder, frames=2)
    return []


def elsewhere(folder, tmp_path):
    poses = ring(5)
    poses[:, :, 3] += [0, 0, 1000]
    return ["--targets", camera_path(tmp_path, poses)]


def unreadable(folder, tmp_path):
    (folder / "images" / "frame_007.jpg").write_bytes(b"no image")
    return ["--method", "sharpest"]


def unreadable_pick(folder, tmp_path):
    """Of the images `fsel` opens only those that it picked, for the report."""
    for file in (folder / "images").iterdir():
        file.write_bytes(b"no image")
    return []


def leads_outside(folder, tmp_path):
    for file in (folder / "sparse" / "0").iterdir():
        file.unlink()
    frames = [
        {"file_path": "../../secret.jpg", "transform_matrix": np.eye(4).tolist()} for _ in "abc"
    ]
    intrinsics = {"w": 64, "h": 48, "fl_x": 60}
    (folder / "transforms.json").write_text(json.dumps(intrinsics | {"frames": frames}))
    return []


def unknown_name(folder, tmp_path):
    (tmp_path / "names.txt").write_text("frame_3.jpg\n")
    return ["--targets", tmp_path / "names.txt"]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (no_poses, ["capture", "no known layout"]),
        (two_frames, ["2 frames would leave nothing to select", "at least 3"]),
        (elsewhere, ["far from every camera", "another world frame"]),
        (unreadable, ["frame_007.jpg", "not a readable image"]),
        (unreadable_pick, ["frame_", "not a readable image"]),
        (leads_outside, ["../../secret.jpg", "leads outside"]),
        (unknown_name, ["names.txt", "'frame_3.jpg'", "'frame_000.jpg'"]),
        (lambda *_: ["-k", 25], ["k is 25", "1 to 24"]),
        (lambda *_: ["-k", 22, "--targets", "every:8"], ["1 to 21", "3 being held out"]),
        (lambda *_: ["--targets", "every:1"], ["'every:1'", "every:N"]),
        (lambda *_: ["--targets", "nowhere.json"], ["nowhere.json", "no such file"]),
        (lambda *_: ["--method", "best"], ["'best'", "allowed: fsel"]),
        (lambda *_: ["--layout", "kitti"], ["'kitti'", "allowed: auto"]),
    ],
)
def test_bad_input_is_refused_in_one_line(damage, said, capture, tmp_path, capsys):
    more = damage(capture, tmp_path)
    out = tmp_path / "out"
    assert select(capture, "-k", 2, "-o", out, *more) == 1
    printed = capsys.readouterr().err
    assert len(printed.strip().splitlines()) == 1
    for part in said:
        assert part in printed
    assert {path.name for path in tmp_path.iterdir()} <= {"capture", "names.txt", "path.json"}


def test_an_algebra_without_an_answer_names_the_capture(capture, tmp_path, monkeypatch, capsys):
    def fail(*_args, **_keywords):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("fsel.cli.select.select_frames", fail)
    assert select(capture, "-k", 3, "-o", tmp_path / "out") == 1
    printed = capsys.readouterr().err
    assert printed.startswith(f"fsel: {capture}: ")
    assert "Singular matrix" in printed
    assert not (tmp_path / "out").exists()


def test_a_name_that_leads_out_of_the_subset_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"'\.\./x\.jpg': its name leads out"):
        placing.inside(tmp_path / "images", "../x.jpg")


def test_an_existing_folder_is_replaced_only_when_forced(capture, tmp_path, capsys):
    out = tmp_path / "out"
    assert select(capture, "-k", 4, "-o", out) == 0
    before = (out / "selection.json").read_text()
    assert select(capture, "-k", 5, "-o", out) == 1
    assert "--force" in capsys.readouterr().err
    assert (out / "selection.json").read_text() == before
    assert select(capture, "-k", 5, "-o", out, "--force") == 0
    assert len(record_of(out)["frames"]) == 5
    assert len(list((out / "images").iterdir())) == 5


def test_a_read_only_disk_is_refused_before_work(capture, tmp_path, monkeypatch, capsys):
    real = Path.mkdir

    def refuse(self, *arguments, **options):
        if self.name.endswith(".out"):
            raise OSError(errno.EROFS, "Read-only file system", str(self))
        return real(self, *arguments, **options)

    monkeypatch.setattr(Path, "mkdir", refuse)
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("an image was opened"))
    assert select(capture, "-k", 4, "-o", tmp_path / "out") == 1
    assert "Read-only file system" in capsys.readouterr().err


@pytest.mark.parametrize("names", [(), ("what/was/read.jpg", None, "out/read.jpg")])
def test_a_full_disk_leaves_nothing(names, capture, tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device", *names)

    monkeypatch.setattr(placing.shutil, "copy2", full)
    assert select(capture, "-k", 4, "-o", tmp_path / "out") == 1
    assert capsys.readouterr().err == f"fsel: {tmp_path}/out: No space left on device\n"
    assert {path.name for path in tmp_path.iterdir()} == {"capture"}


@pytest.mark.parametrize("force", [False, True])
def test_an_interruption_leaves_what_was_there(force, capture, tmp_path, monkeypatch):
    out = tmp_path / "out"
    if force:
        assert select(capture, "-k", 4, "-o", out) == 0
        before = (out / "selection.json").read_bytes()

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(subset, "write_forms", interrupt)
    assert select(capture, "-k", 5, "-o", out, *["--force"] * force) == 130
    assert {path.name for path in tmp_path.iterdir()} == {"capture", *["out"] * force}
    if force:
        assert (out / "selection.json").read_bytes() == before


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_nothing_half_written(number, code, tmp_path):
    write_ring(tmp_path / "capture", frames=12)
    script = (
        "import sys, fsel.selection.export.placing as p, time; "
        "p.place = lambda *a: (print('copying', flush=True), time.sleep(60)); "
        "from fsel.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", script, "select", str(tmp_path / "capture"), "-k", "4"]
    with subprocess.Popen(
        [*command, "--geometry-only", "--quiet", "-o", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # what runs in the background of a script is born deaf to Ctrl-C
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        assert process.stdout.readline() == "copying\n"
        time.sleep(0.1)
        process.send_signal(number)
        _, error = process.communicate(timeout=30)
    assert process.returncode == code
    assert error == "fsel: interrupted, nothing was written\n"
    assert {path.name for path in tmp_path.iterdir()} == {"capture"}


def test_two_runs_write_the_same_bytes_but_for_their_times(capture, tmp_path):
    for out, words in (("a", []), ("b", []), ("c", ["--targets", "every:6"])):
        assert select(capture, "-k", 4, *words, "-o", tmp_path / out) == 0
    for path in (tmp_path / "a").rglob("*"):
        if path.is_file() and path.name != "selection.json":
            other = tmp_path / "b" / path.relative_to(tmp_path / "a")
            said = other.read_bytes().replace(
                str(tmp_path / "b").encode(), str(tmp_path / "a").encode()
            )
            assert path.read_bytes() == said, path.name  # the page has the command line
    scenes = [json.loads((tmp_path / p / "scene.json").read_text()) for p in ("a", "c/train")]
    assert [scene["scene_name"] for scene in scenes] == ["capture", "capture_train"]
