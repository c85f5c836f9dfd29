"""`fsel select`: what it refuses, and what it leaves behind when it is cut off."""

import errno
import json
import signal
from contextlib import suppress
from pathlib import Path

import cv2
import pytest
from small_captures import camera_path, ring, select

from fsel.selection.export import placing, subset


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["-k", 25], ["k is 25", "1 to 24"]),
        (["-k", 22, "--targets", "every:8"], ["1 to 21", "3 being held out"]),
        (["--targets", "every:1"], ["'every:1'", "every:N"]),
        (["--targets", "nowhere.json"], ["nowhere.json", "no such file"]),
        (["--targets", "path.json"], ["far from every camera", "another world frame"]),
        (["--targets", "names.txt"], ["names.txt", "'frame_3.jpg'", "'frame_000.jpg'"]),
        (["--method", "best"], ["'best'", "allowed: fsel"]),
        (["-k", "4", "--loss", "1"], ["--loss 1", "-k auto"]),
        (["--layout", "kitti"], ["'kitti'", "allowed: auto"]),
        (["--views"], ["--views", "panoramas"]),
    ],
)
def test_bad_input_is_refused_in_one_line(asked, said, capture, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("names.txt").write_text("frame_3.jpg\n")
    poses = ring(5)
    poses[:, :, 3] += [0, 0, 1000]
    camera_path(tmp_path, poses)
    assert select(capture, "-k", 2, "-o", "out", *asked) == 1
    printed = capsys.readouterr().err
    assert len(printed.strip().splitlines()) == 1
    assert all(part in printed for part in said), printed
    assert {path.name for path in tmp_path.iterdir()} == {"capture", "names.txt", "path.json"}


def test_a_name_that_leads_out_of_the_subset_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"'\.\./x\.jpg': its name leads out"):
        placing.inside(tmp_path / "images", "../x.jpg")


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


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_what_was_there(
    number, code, capture, tmp_path, monkeypatch, capsys, request
):
    # a shell has what it starts in the background ignore SIGINT, and so does `fsel` then
    handler = signal.signal(number, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(number, handler))
    out = tmp_path / "out"
    assert select(capture, "-k", 4, "-o", out) == 0
    before = (out / "selection.json").read_bytes()
    monkeypatch.setattr(subset, "write_forms", lambda *_: signal.raise_signal(number))
    assert select(capture, "-k", 5, "-o", out, "--force") == code
    assert select(capture, "-k", 5, "-o", tmp_path / "other") == code
    assert capsys.readouterr().err == "fsel: interrupted, nothing was written\n" * 2
    assert {path.name for path in tmp_path.iterdir()} == {"capture", "out"}
    assert (out / "selection.json").read_bytes() == before

    def lost(*_):  # as in a library that calls back
        with suppress(KeyboardInterrupt):
            signal.raise_signal(number)

    monkeypatch.setattr(subset, "write_forms", lost)
    assert select(capture, "-k", 4, "-o", tmp_path / "late") == code
    assert capsys.readouterr().err == "fsel: interrupted, after all was written\n"


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
