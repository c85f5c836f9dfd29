"""`fsel poses`, and commands on what has no poses yet: a video, photos."""

import json
import shlex
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pose_program
import pycolmap
import pytest
from small_captures import record_of, run, select, state_orientation, write_video

from fsel.captures import opening
from fsel.captures.colmap.runs import plan
from fsel.captures.images import files as image_files
from fsel.captures.opening import Opening

sys.path.insert(0, str(Path(__file__).parents[1] / "captures"))


@pytest.fixture(scope="module")
def shots():
    """Ten views of textured planes, and one of nothing."""
    from test_sfm import poses, render

    return [*render(poses()), np.full((180, 240, 3), 99, np.uint8)]


def write_heic(path, image):
    import pillow_heif

    pillow_heif.from_bytes("RGB", image.shape[1::-1], image.tobytes()).save(path, quality=95)


def test_a_video_is_placed_once_and_selected_from(shots, cache, tmp_path, capsys, monkeypatch):
    video = tmp_path / "walk.avi"
    write_video(video, shots, rate=5)
    out = tmp_path / "capture"
    assert run("poses", video, "--rate", 5, "-o", out) == 0
    said = capsys.readouterr()
    assert "COLMAP placed 10 of 11 frames" in said.out
    assert "1 frame not placed: frame_00010.jpg; lost: 1.8 to 2.0 s. Hint: --feat" in said.err
    report = json.loads((out / "poses.json").read_text())
    assert report["not_placed"] == ["frame_00010.jpg"]
    assert report["other"]["placed"] == 10  # asked, since one is not placed
    assert report["other"]["degrees"] < 1
    assert [shot["seconds"] for shot in report["video"]] == pytest.approx(np.arange(11) / 5)
    assert run("info", out, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["frames"], found["unregistered"]) == (10, ["frame_00010.jpg"])
    for name in ("match_image_pairs", "match_exhaustive", "extract_features"):
        monkeypatch.setattr(pycolmap, name, lambda *_, **__: pytest.fail("was matched again"))
    assert select(video, "--rate", 5, "-k", 4, "-o", tmp_path / "picked") == 0
    record = record_of(tmp_path / "picked")
    assert len(record["frames"]) == 4
    assert record["capture"]["folder"] == str(video)
    lost = {"video": "walk.avi", "from": 1.8, "to": 2.0, "frames": 1}
    placed = record["capture"]["placed"]
    assert (placed["frames"], placed["placed"]) == (11, 10)
    assert placed["not_placed"] == ["frame_00010.jpg"]
    assert placed["lost"] == [pytest.approx(lost)]
    reasons = {entry["name"]: entry["reason"] for entry in record["left"]}
    assert reasons["frame_00010.jpg"] == "not placed by COLMAP, at 2.0 s"
    page = (tmp_path / "picked" / "report.html").read_text(encoding="utf-8")
    assert f"colmap at {video}. Views to render" in page
    assert "1 frame not placed: frame_00010.jpg; lost: 1.8 to 2.0 s" in page
    assert str(cache) not in page
    assert run("select", video, "--rate", 5, "-k", 30, "-o", tmp_path / "no") == 1
    refused = f"{video}: k is 30, but COLMAP placed 10 of 11 frames; allowed: up to 9. Hint:"
    assert refused in capsys.readouterr().err


@pytest.mark.parametrize(("step", "rate"), [(90, 15), (2, 31)])  # at most twice what was taken
def test_the_hint_is_a_rate_where_a_video_has_more_frames(step, rate):
    seconds = np.arange(0, 181, step) / 30
    found = {"by": "COLMAP", "placed": ["a", "b"], "frames": len(seconds)}
    found["video"] = [{"name": "a", "index": round(30 * at), "seconds": at} for at in seconds]
    walk = Opening((Path("walk.mp4"),), wanted=30)
    said = rf"k is 30, .* 2 of {len(seconds)} frames; .*Hint: --rate {rate} samples more"
    with pytest.raises(ValueError, match=said):
        opening._check_number(walk, found)
    opening._check_number(replace(walk, wanted=0), found)


def test_a_run_that_was_cut_off_goes_on_where_it_was(shots, cache, tmp_path, monkeypatch, capsys):
    photos = tmp_path / "photos"
    image_files.write(np.stack(shots[:6]), photos, [f"{i}.jpg" for i in range(6)])

    def cut_off(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr("fsel.captures.colmap.mapping._steps", cut_off)
        assert run("poses", photos, "-o", tmp_path / "capture") == 130
    assert not (tmp_path / "capture").exists()
    assert "run the same command again to resume" in capsys.readouterr().err
    monkeypatch.setattr(pycolmap, "extract_features", lambda *_, **__: pytest.fail("again"))
    assert run("info", photos, "--poses", "colmap", "--quiet") == 0
    assert len(list(cache.glob("*/capture/sparse/0/images.bin"))) == 1


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("poses empty -o out", "0 photos (.jpg, "),
        ("poses gone -o out", "gone: no such folder"),
        ("info empty", "the folder is empty"),
        ("info empty --rate 2", "is no video"),
        ("info gone.mp4", "gone.mp4: no such file"),
        ("select raw -k 4 --targets walk.mp4 -o out", "every:N"),
        ("info grey", "--poses colmap"),
        ("info raw", "RawTherapee"),
        ("info .", "walk.mp4"),
        ("poses walk.insv -o out", "360-degree camera"),
        ("select walk.mp4 -k 3 -o out", "walk.mp4: not a readable video"),
        ("select half/cut.mp4 -k 3 -o out", "cut.mp4: truncated"),
        ("poses walk.mp4 ./walk.mp4 -o out", "walk.mp4: the same video or folder is given twice"),
        ("poses grey -o out", "fsel: grey: COLMAP placed 0 of 3 frames; at least 3"),
    ],
)
def test_what_cannot_be_posed_is_refused(line, said, cache, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "half").mkdir()
    (tmp_path / "half" / "cut.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(99))
    (tmp_path / "raw").mkdir()
    for name in ("walk.mp4", "walk.insv", "raw/DSC01.ARW"):
        (tmp_path / name).write_bytes(b"no video")
    image_files.write(
        np.full((3, 48, 64, 3), 99, np.uint8), tmp_path / "grey", ["a.jpg", "b.jpg", "c.jpg"]
    )
    assert run(*line.split()) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-k 0", "k is 0"),
        ("-k 100000", "up to 11"),
        ("-k 5 --rate 2", "up to 4"),
        ("-k 3 --always gone.txt", "gone.txt"),
        ("-k 3 --targets gone.txt", "gone.txt"),
        ("-k 3 --targets evry:8", "'evry:8'"),
        ("-k 3 --masks gone", "gone: no such folder"),
        ("-k 3 --box 1 0 0 0 1 1", "box is"),
        ("-k 3 --start 4", "2.4 s"),
        ("-k 3 --end 0:04", "2.4 s"),
        ("walk.avi -k 3 --end 1", "2 videos"),
    ],
)
def test_refused_before_a_video_is_decoded(words, said, cache, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_video(Path("walk.avi"), np.zeros((12, 48, 64, 3), np.uint8), rate=5)
    shutil.copy("walk.avi", "other.avi")
    monkeypatch.setattr(opening.video, "thin", lambda *_, **__: pytest.fail("was decoded"))
    assert run("select", "other.avi", *words.split(), "-o", "out") == 1
    assert said in capsys.readouterr().err


def test_a_part_of_a_video_is_taken_and_the_plan_comes_first(cache, tmp_path, capsys, monkeypatch):
    rng, said = np.random.default_rng(0), []
    film = [np.kron(rng.integers(0, 255, (6, 8, 3)), np.ones((8, 8, 1))) for _ in range(40)]
    write_video(tmp_path / "walk.avi", np.array(film, np.uint8), rate=10)
    by = shlex.join(pose_program.written(tmp_path))
    part = ["--start", "0:01", "--end", "2.5s"]
    assert run("poses", tmp_path / "walk.avi", *part, "--by", by, "-o", tmp_path / "out") == 0
    shots = json.loads((tmp_path / "out" / "poses.json").read_text())["video"]
    assert [shot["index"] for shot in shots] == list(range(10, 26))
    capsys.readouterr()
    monkeypatch.setattr(
        opening.placement, "place", lambda *_: said.append(capsys.readouterr().out) or 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        run("poses", tmp_path / "walk.avi", *part, "-o", tmp_path / "colmap")
    assert "15 frames, 105 pairs: less than a minute" in said[0]


def test_a_plan_grows_with_the_photos_and_their_size():
    asked = [(100, 0.9e6, True), (2000, 0.9e6, False), (100, 12e6, False)]
    said = [plan(n, int(size), ordered=film, cores=1) for n, size, film in asked]
    walk, many, large = (int(one.partition("about ")[2].split()[0]) for one in said)
    assert 1 <= walk <= 3
    assert min(many / 15, large / 2) > walk


def test_photos_that_cannot_be_read_are_skipped_where_asked(cache, tmp_path, capsys, monkeypatch):
    photos, posed = tmp_path / "photos", []
    monkeypatch.setattr(
        opening.placement, "place", lambda sources, *_: posed.append(sources[0].photos) or 1 / 0
    )
    image_files.write(np.zeros((4, 24, 32, 3), np.uint8), photos, [f"{x}.jpg" for x in "abcd"])
    (photos / "b.jpg").write_bytes((photos / "b.jpg").read_bytes()[:50])
    with pytest.raises(ZeroDivisionError):
        run("poses", photos, "--skip-unreadable", "-o", tmp_path / "out")
    assert "1 image skipped: b.jpg (image file is truncated (50 bytes))" in capsys.readouterr().err
    assert [file.name for file in posed[0]] == ["a.jpg", "c.jpg", "d.jpg"]
    assert run("poses", photos, "-o", tmp_path / "out") == 1
    assert "b.jpg: image file is truncated (50 bytes)" in capsys.readouterr().err


def test_photos_of_formats_that_are_not_read_are_named(cache, tmp_path, capsys, monkeypatch):
    (tmp_path / "IMG_1.HEIC").write_bytes(b"photo")
    monkeypatch.setattr(image_files, "reads_heic", lambda: False)
    assert run("info", tmp_path, "--poses", "colmap") == 1
    printed = capsys.readouterr().err
    said = "1 photo skipped; convert to JPEG or PNG to use them: IMG_1.HEIC. Hint: pip install 'f"
    assert said in printed
    assert f"{tmp_path}: 0 photos" in printed


def test_videos_and_photos_of_one_scene_are_placed_together(shots, cache, tmp_path, capsys):
    """Of other shapes: two videos, one of them cut at the top, and photos as phones keep them."""
    pytest.importorskip("pillow_heif")
    one, two = tmp_path / "walk.avi", tmp_path / "other" / "walk.avi"
    two.parent.mkdir()
    write_video(one, shots[:6], rate=5)
    write_video(two, [shot[30:] for shot in shots[3:8]], rate=5)
    (tmp_path / "photos").mkdir()
    for i in (7, 8, 9):
        write_heic(tmp_path / "photos" / f"IMG_{i}.HEIC", shots[i])
    out = tmp_path / "out"
    asked = [one, two, tmp_path / "photos", "-k", 8, "--targets", "every:7"]
    assert run("select", *asked, "-o", out) == 0
    assert "COLMAP placed 14 of 14 frames" in capsys.readouterr().out
    names = (out / "frames.txt").read_text().split()
    assert {name.partition("/")[0] for name in names} == {"walk", "walk-2", "photos"}
    assert record_of(out)["capture"]["beside"] == [str(two), str(tmp_path / "photos")]
    model = pycolmap.Reconstruction(str(out / "train" / "sparse" / "0"))
    cameras = {image.name.partition("/")[0]: image.camera for image in model.images.values()}
    assert (cameras["walk"].height, cameras["walk-2"].height) == (180, 150)
    assert len({camera.camera_id for camera in cameras.values()}) == 3
    for name in names:
        shown = image_files.load(out / "train" / "images" / name)
        assert shown.shape[0] == cameras[name.partition("/")[0]].height


def test_photos_are_turned_upright_before_they_are_matched(shots, cache, tmp_path, capsys):
    """A phone that was held in four ways: EXIF tells how, and the cameras are of one size."""
    photos, names = tmp_path / "photos", [f"{i}.jpg" for i in range(5)]
    ways = {0: (1, 0), 1: (6, 1), 2: (3, 2), 3: (8, 3)}  # value, quarter turns to the left
    for i, (shot, name) in enumerate(zip(shots, names, strict=False)):
        value, turns = ways[i % 4]
        image_files.write(np.rot90(shot, turns)[None], photos, [name])
        if value > 1:
            state_orientation(photos / name, value)
    out = tmp_path / "out"
    assert run("poses", photos, "-o", out) == 0
    said = capsys.readouterr().out
    assert "COLMAP placed 5 of 5 frames" in said
    assert said.count("3 of 5 photos upright, as their EXIF says; JPEGs encoded again") == 1
    turned = json.loads((out / "poses.json").read_text())["turned"]
    assert turned == ["1.jpg", "2.jpg", "3.jpg"]
    model = pycolmap.Reconstruction(str(out / "sparse" / "0"))
    assert [(c.width, c.height) for c in model.cameras.values()] == [(240, 180)]
    for shot, name in zip(shots, names, strict=False):
        found = cv2.imread(str(out / "images" / name))[..., ::-1]  # applies EXIF
        assert found.shape == (180, 240, 3)
        assert np.abs(found.astype(int) - shot).mean() < 12  # 40 and more where turned otherwise
        np.testing.assert_array_equal(image_files.load(out / "images" / name), found)
    poses = {image.name: image.cam_from_world().rotation for image in model.images.values()}
    turn = poses["0.jpg"].inverse() * poses["1.jpg"]
    assert np.degrees(turn.angle()) < 5  # neighbours on the arc, 1.8 degrees apart
