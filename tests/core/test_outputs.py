"""Outputs appear whole or not at all, and replace nothing without `force`."""

import os
from pathlib import Path

import pytest

from fsel.core.files import host, unfinished
from fsel.core.outputs import LISTED, staged


def folder(out, text="new", force=False, inputs=(), between=lambda: None):
    with staged(out, inputs, force) as stage:
        (stage / "images").mkdir()
        (stage / "images" / "a.jpg").write_text(text)
        between()


def scene(out, text="new", force=False, inputs=(), between=lambda: None):
    with staged(out, inputs, force, folder=False) as stage:
        stage.write_text(text)
        between()


def names(path):
    return {entry.name for entry in path.iterdir()}


def fail(*_):
    raise OSError("full")


def content(out):
    return (out / "images" / "a.jpg" if out.is_dir() else out).read_text()


@pytest.mark.parametrize("write", [folder, scene])
def test_an_output_is_replaced_with_force_alone(write, tmp_path):
    out = tmp_path / "out"
    write(out, "old")
    with pytest.raises(FileExistsError, match="out"):
        write(out)
    assert content(out) == "old"
    write(out, force=True)
    assert content(out) == "new"
    assert names(tmp_path) == {"out"}


@pytest.mark.parametrize("write", [folder, scene])
def test_an_output_that_appears_meanwhile_is_left_as_it_is(write, tmp_path):
    out = tmp_path / "out"
    with pytest.raises(FileExistsError, match="out"):
        write(out, between=lambda: out.write_text("another's"))
    assert out.read_text() == "another's"
    assert names(tmp_path) == {"out"}


@pytest.mark.parametrize("write", [folder, scene])
def test_an_old_output_stays_where_the_new_one_fails(write, tmp_path, monkeypatch):
    out = tmp_path / "out"
    write(out, "old")
    with pytest.raises(OSError, match="full"):
        write(out, force=True, between=fail)
    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="full"):
        write(out, force=True)
    assert content(out) == "old"
    assert names(tmp_path) == {"out"}


@pytest.mark.parametrize("own", ["notes.txt", "images/b.jpg", "images/b", "empty.jpg"])
@pytest.mark.parametrize("write", [folder, scene])
def test_a_folder_with_anything_of_a_persons_is_never_replaced(own, write, tmp_path):
    out = tmp_path / "out"
    folder(out, "old")
    (out / ".DS_Store").touch()
    (tmp_path / "photos").mkdir()
    (out / own).symlink_to(tmp_path / ("photos" if own == "images/b" else "nowhere"))
    with pytest.raises(FileExistsError, match=own):
        write(out, force=True)
    (out / own).unlink()
    with pytest.raises(FileExistsError, match=own):
        write(out, force=True, between=lambda: (out / own).touch())  # while the command works
    assert content(out) == "old"
    (out / own).unlink()
    write(out, force=True)
    assert names(tmp_path) == {"out", "photos"}


def test_a_folder_takes_the_place_of_no_file(tmp_path):
    scene(tmp_path / "out", "old")
    with pytest.raises(FileExistsError, match="is a file"):
        folder(tmp_path / "out", force=True)
    assert content(tmp_path / "out") == "old"


@pytest.mark.parametrize("write", [folder, scene])
def test_a_name_that_is_not_utf8_is_refused_before_work(write, tmp_path):
    strange = tmp_path / os.fsdecode(b"a\xff")
    for out, inputs in ((strange / "out", []), (tmp_path / "größe", [strange])):
        with pytest.raises(ValueError, match=r"udcff.*not UTF-8"):
            write(out, inputs=inputs)
    write(tmp_path / "größe")
    assert names(tmp_path) == {"größe"}


def test_an_output_is_not_part_of_an_input(tmp_path):
    capture = tmp_path / "capture"
    (capture / "images").mkdir(parents=True)
    (tmp_path / "alias").symlink_to(capture)
    for out in [capture, capture / "images", tmp_path, tmp_path / "alias" / "out"]:
        with pytest.raises(ValueError, match="capture"):
            folder(out, force=True, inputs=[capture])
    assert names(capture) == {"images"}


def test_force_never_replaces_the_folders_a_person_is_in(tmp_path, monkeypatch):
    (tmp_path / "at" / "work").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "at" / "work")
    for out in (tmp_path / "at", Path("..")):
        with pytest.raises(FileExistsError, match="working folder"):
            folder(out, force=True)
    folder(Path("."))  # empty
    assert names(tmp_path / "at" / "work") == {LISTED, "images"}


def test_what_dead_processes_left_is_cleared(tmp_path):
    out, dead = tmp_path / "out", 999_999_999
    for name in (f".{host()}.{dead}.out", "out"):
        (tmp_path / name).mkdir()
    unfinished(out).mkdir()  # by a process that had this one's number
    kept = {f".elsewhere.{dead}.out", f".{host()}.1.out", f".{host()}.{dead}.out2", ".out.old"}
    for name in kept:
        (tmp_path / name).mkdir()
    folder(out)
    assert names(tmp_path) == {"out"} | kept


def test_a_symbolic_link_is_followed(tmp_path):
    real, out = tmp_path / "disk" / "real", tmp_path / "out"
    real.parent.mkdir()
    out.symlink_to(real)
    folder(out, "old")
    folder(out, "new", force=True)
    assert out.is_symlink()
    assert content(real) == "new"
    assert names(tmp_path) == {"disk", "out"}
    assert names(tmp_path / "disk") == {"real"}
