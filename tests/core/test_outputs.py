"""Outputs appear whole or not at all, and replace nothing without `force`."""

from pathlib import Path

import pytest

from fsel.core.files import host, unfinished
from fsel.core.outputs import staged


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
    assert names(tmp_path / "at" / "work") == {"images"}


def test_what_dead_processes_left_is_cleared(tmp_path):
    out, dead = tmp_path / "out", 999_999_999
    for name in (f".{host()}.{dead}.out", ".out.old", "out"):
        (tmp_path / name).mkdir()
    unfinished(out).mkdir()  # by a process that had this one's number
    kept = {f".elsewhere.{dead}.out", f".{host()}.1.out", f".{host()}.{dead}.out2"}
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
