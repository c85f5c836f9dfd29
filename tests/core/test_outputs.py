"""Outputs appear whole or not at all, and replace nothing that is not theirs."""

from pathlib import Path

import pytest

from fsel.core.files import host, unfinished
from fsel.core.outputs import staged

PLY = b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nend_header\n"


def folder(out, text="new", force=False, inputs=(), between=lambda: None):
    with staged(out, "select", inputs, force) as stage:
        (stage / "images").mkdir()
        (stage / "images" / "a.jpg").write_text(text)
        between()


def scene(out, content=PLY, force=False, inputs=(), between=lambda: None):
    with staged(out, "reconstruct", inputs, force, folder=False) as stage:
        stage.write_bytes(content)
        between()


def names(path):
    return {entry.name for entry in path.iterdir()}


def fail(*_):
    raise OSError("full")


def other_run(path):
    (path / "other").rename(path / "out")


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("write", [folder, scene])
def test_an_output_that_appears_meanwhile_is_left_as_it_is(write, force, tmp_path):
    write(tmp_path / "other")
    with pytest.raises(FileExistsError, match="made or changed by somebody else"):
        write(tmp_path / "out", force=force, between=lambda: other_run(tmp_path))
    with pytest.raises(FileExistsError, match="made or changed by somebody else"):
        write(tmp_path / "mine", between=lambda: (tmp_path / "mine").write_text("mine"))
    assert (tmp_path / "mine").read_text() == "mine"
    assert names(tmp_path) == {"out", "mine"}


@pytest.mark.parametrize("write", [folder, scene])
def test_force_replaces_what_the_command_wrote(write, tmp_path):
    out = tmp_path / "out"
    write(out)
    with pytest.raises(FileExistsError, match="--force replaces it"):
        write(out)
    before = sorted(path.stat().st_ino for path in [out, *out.rglob("*")])
    write(out, force=True)
    assert sorted(path.stat().st_ino for path in [out, *out.rglob("*")]) != before
    assert names(tmp_path) == {"out"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda out: (out / "images" / "mine.jpg").write_text("mine"), "images/mine.jpg"),
        (lambda out: (out / "images" / "a.jpg").write_text("mine"), "'images/a.jpg' was changed"),
        (lambda out: (out / "link").symlink_to("elsewhere"), "'link'"),
        (lambda out: (out / "manifest.json").unlink(), "no manifest.json"),
        (lambda out: (out / "manifest.json").write_text("[1]"), "no manifest.json"),
    ],
)
def test_force_leaves_what_a_person_made_or_changed(change, said, tmp_path):
    out = tmp_path / "out"
    folder(out, "old")
    change(out)
    with pytest.raises(FileExistsError, match=said):
        folder(out, force=True)
    assert (out / "images" / "a.jpg").read_text() in ("old", "mine")
    later = tmp_path / "later"
    folder(later, "old")
    with pytest.raises(FileExistsError, match="changed by somebody else while this command ran"):
        folder(later, force=True, between=lambda: change(later))
    assert (later / "images" / "a.jpg").read_text() in ("old", "mine")
    assert names(tmp_path) == {"out", "later"}


def test_force_leaves_another_command_s_output(tmp_path):
    folder(tmp_path / "out")
    with (
        pytest.raises(FileExistsError, match="written by 'fsel select'"),
        staged(tmp_path / "out", "compare", (), True),
    ):
        pytest.fail("the work began")


def test_force_leaves_a_scene_of_somebody_else(tmp_path):
    out = tmp_path / "scene.ply"
    out.write_bytes(PLY)
    with pytest.raises(FileExistsError, match="names no earlier run of fsel reconstruct"):
        scene(out, force=True)
    scene(tmp_path / "own.ply")
    with (tmp_path / "own.ply").open("ab") as file:
        file.write(b"more")
    with pytest.raises(FileExistsError, match="was changed since"):
        scene(tmp_path / "own.ply", force=True)


def test_an_output_is_not_part_of_an_input(tmp_path):
    capture = tmp_path / "capture"
    (capture / "images").mkdir(parents=True)
    (tmp_path / "alias").symlink_to(capture)
    outputs = [capture, capture / "images", tmp_path, tmp_path / "alias" / "out"]
    for out in outputs:
        with pytest.raises(ValueError, match="may not be, hold or lie in what is read"):
            folder(out, force=True, inputs=[capture])
    assert names(capture) == {"images"}


def test_what_dead_processes_left_is_cleared(tmp_path):
    out, dead = tmp_path / "out", 999_999_999
    (tmp_path / f".{host()}.{dead}.out").mkdir()
    unfinished(out).mkdir()  # by a process that had this one's number
    kept = {f".elsewhere.{dead}.out", f".{host()}.1.out", f".{host()}.{dead}.out2"}
    for name in kept:
        (tmp_path / name).mkdir()
    out.mkdir()
    folder(out)
    assert names(tmp_path) == {"out"} | kept


def test_an_output_hidden_by_a_kill_comes_back(tmp_path):
    out = tmp_path / "out"
    folder(out, "old")
    out.rename(tmp_path / ".out.old")
    with pytest.raises(FileExistsError, match="exists already"):
        folder(out)
    assert (out / "images" / "a.jpg").read_text() == "old"
    folder(tmp_path / "other")
    (tmp_path / "other").rename(tmp_path / ".out.old")  # killed before it was removed
    folder(out, "new", force=True)
    assert (out / "images" / "a.jpg").read_text() == "new"
    assert names(tmp_path) == {"out"}


def test_an_old_output_stays_where_the_new_one_cannot_take_its_name(tmp_path, monkeypatch):
    out = tmp_path / "out"
    folder(out, "old")
    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="full"):
        folder(out, "new", force=True)
    assert (out / "images" / "a.jpg").read_text() == "old"
    assert names(tmp_path) == {"out"}


def test_a_symbolic_link_is_followed(tmp_path):
    real, out = tmp_path / "disk" / "real", tmp_path / "out"
    real.parent.mkdir()
    out.symlink_to(real)
    folder(out, "old")
    folder(out, "new", force=True)
    assert out.is_symlink()
    assert (real / "images" / "a.jpg").read_text() == "new"
    assert names(tmp_path) == {"disk", "out"}
    assert names(tmp_path / "disk") == {"real"}


def test_a_failure_leaves_no_folders_that_were_made(tmp_path):
    with pytest.raises(OSError, match="full"):
        folder(tmp_path / "a" / "b" / "out", between=fail)
    assert not names(tmp_path)
