"""The poses that are kept: by a program, in the cache, damaged there, and told apart."""

import errno
import json
import shlex
import shutil

import numpy as np
import pose_program
import pycolmap
import pytest
from small_captures import run

from fsel.captures import opening
from fsel.captures.colmap.estimator import Estimator
from fsel.captures.images import files as image_files
from fsel.captures.images.video import Sampling
from fsel.captures.poses import kept, placement
from fsel.captures.sampling import Source


def test_a_program_finds_the_poses_once_and_is_named(cache, tmp_path, capsys, monkeypatch):
    for name in ("match_image_pairs", "match_exhaustive", "extract_features"):
        monkeypatch.setattr(pycolmap, name, lambda *_, **__: pytest.fail("was matched"))
    photos, out = tmp_path / "photos", tmp_path / "out"
    image_files.write(np.full((5, 48, 64, 3), 99, np.uint8), photos, [f"{i}.jpg" for i in range(5)])
    by = shlex.join(pose_program.written(tmp_path))
    assert run("poses", photos, "--by", "nowhere {folder}", "-o", out) == 1
    assert "fsel: poses by nowhere: no program 'nowhere' in " in capsys.readouterr().err
    assert run("poses", photos, "--by", 'python "x', "-o", out) == 1
    assert capsys.readouterr().err == 'fsel: --by python "x: No closing quotation\n'
    assert not out.exists()
    assert not cache.exists()
    assert run("poses", photos, "--by", by, "-o", out) == 0
    said = capsys.readouterr()
    assert "places placed 4 of 5 frames" in said.out
    assert "1 frame not placed: 4.jpg" in said.err
    report = json.loads((out / "poses.json").read_text())
    assert (report["by"], report["not_placed"]) == ("places", ["4.jpg"])
    (tmp_path / "places.py").write_text("exit(1)")  # what was found is kept
    assert run("poses", photos, "--by", by, "-o", out, "--force") == 0
    assert run("poses", photos, "--by", f"{by} again", "-o", out, "--force") == 1
    assert "fsel: poses by places: " in capsys.readouterr().err


def test_the_cache_is_listed_and_cleared_but_for_what_is_in_use(cache, tmp_path, capsys):
    photos = tmp_path / "photos"
    image_files.write(np.full((5, 48, 64, 3), 99, np.uint8), photos, [f"{i}.jpg" for i in range(5)])
    by = shlex.join(pose_program.written(tmp_path))
    assert run("poses", photos, "--by", by, "-o", tmp_path / "out", "--quiet") == 0
    (cache / "lpips_alex.safetensors").write_bytes(bytes(1000))
    (cache / "letters.txt").touch()  # of somebody
    assert run("cache", "--json") == 0
    places, weights = json.loads(capsys.readouterr().out)["entries"]  # a digest comes first
    assert places["of"] == f"poses of {photos}"
    assert weights == {"name": "lpips_alex.safetensors", "bytes": 1000, "of": ""}
    with kept.locked(cache / places["name"] / kept.LOCK):
        assert run("cache", "--clear") == 0
    assert f"{cache / places['name']}: is in use" in capsys.readouterr().err
    assert {path.name for path in cache.iterdir()} == {places["name"], "letters.txt"}
    assert run("cache", "--clear", "--quiet") == 0
    assert [path.name for path in cache.iterdir()] == ["letters.txt"]


@pytest.fixture
def grey(tmp_path):
    """The words of `fsel poses` for photos that a program places."""
    shots = np.full((5, 48, 64, 3), 99, np.uint8)
    image_files.write(shots, tmp_path / "grey", [f"{name}.jpg" for name in "abcde"])
    return ["poses", tmp_path / "grey", "--by", shlex.join(pose_program.written(tmp_path))]


@pytest.mark.parametrize(
    ("damaged", "content"),
    [
        ("poses.json", b""),
        ("poses.json", b'{"x": 1}'),
        ("capture/sparse/0/images.bin", b"\1"),
        ("capture/sparse/0/cameras.bin", None),
        ("capture/images/a.jpg", b""),
    ],
)
def test_what_is_damaged_in_the_cache_is_made_anew(damaged, content, grey, cache, tmp_path, capsys):
    assert run(*grey, "-o", tmp_path / "out") == 0
    file = next(cache.glob(f"*/{damaged}"))
    file.unlink()  # a photo's link, not the photo
    if content is not None:
        file.write_bytes(content)
    for warned in (True, False):
        capsys.readouterr()
        assert run("cache", "--quiet") == 0
        assert run(*grey, "-o", tmp_path / "out", "--force") == 0
        assert ("damaged" in capsys.readouterr().err) == warned
    assert len(json.loads((tmp_path / "out" / "poses.json").read_text())["placed"]) == 4
    file.write_bytes(b"")
    assert run("cache", "--clear") == 0
    assert not any(cache.iterdir())


def test_what_a_cut_off_run_left_damaged_is_made_anew(grey, cache, tmp_path, capsys, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(placement, "_placed", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            run(*grey, "-o", tmp_path / "out")
    next(cache.glob("*/capture/taken.json")).write_bytes(b"")
    assert run(*grey, "-o", tmp_path / "out") == 0
    assert "taken.json" in capsys.readouterr().err


def test_a_full_disk_under_the_cache_is_told(grey, cache, tmp_path, capsys, monkeypatch):
    def full(**_):
        raise OSError(errno.ENOSPC, "No space left on device")

    def vague(*_):
        raise RuntimeError("No registered database factory succeeded.")

    monkeypatch.setattr(placement, "_placed", vague)
    monkeypatch.setattr(kept, "TemporaryFile", full)
    assert run(*grey, "-o", tmp_path / "out") == 1
    (place,) = cache.iterdir()
    assert capsys.readouterr().err == f"fsel: {place}: No space left on device\n"
    assert (place / "capture" / "taken.json").is_file()


def test_settings_and_files_tell_one_cache_from_another(tmp_path):
    one, other = tmp_path / "a.mp4", tmp_path / "b.mp4"
    one.write_bytes(b"video")
    shutil.copy(one, other)
    wide, close = Sampling(10), Sampling(20)
    asked = [([one], wide), ([one], close), ([other], wide), ([one, other], wide)]
    keys = [
        opening._digest([Source(path) for path in paths], how, None, "sift", None)
        for paths, how in asked
    ]
    keys += [
        opening._digest([Source(one)], wide, Estimator(by=[word]), "sift", None) for word in "ab"
    ]
    keys.append(opening._digest([Source(one)], wide, None, "aliked", None))
    keys.append(opening._digest([Source(one)], wide, None, "sift", Estimator(by=["a"])))
    assert len(set(keys)) == 8
    assert opening._digest([Source(one)], Sampling(10), None, "sift", None) == keys[0]
    one.write_bytes(b"another video")
    assert opening._digest([Source(one)], wide, None, "sift", None) != keys[0]
