"""`fsel info`, `fsel select -k auto`, `fsel compare`, `fsel reconstruct`."""

import json
import re
import sys
import time
from argparse import Namespace
from dataclasses import asdict, replace

import cv2
import numpy as np
import pytest
from selection_problems import capture_of
from small_captures import film, record_of, run, select, write_ring

import fsel
from fsel.captures.images import files as image_files
from fsel.cli import compare, console
from fsel.cli.console import Console
from fsel.core.points import SparsePoints
from fsel.reconstruct.gaussians.settings import QUALITIES
from fsel.selection.budget import shipped
from fsel.selection.scene_depth import viewing_distance


@pytest.mark.parametrize(
    ("terminal", "delay", "quiet", "shown"),
    [
        (True, 0.0, False, True),
        (True, 60.0, False, False),
        (False, 0.0, False, True),
        (False, 60.0, False, False),
        (True, 0.0, True, False),
    ],
)
def test_long_loops_show_their_progress(terminal, delay, quiet, shown, monkeypatch, capsys):
    monkeypatch.setattr(console, "PATIENCE", delay if terminal else 60.0)
    monkeypatch.setattr(console, "EVERY", 60.0 if terminal else delay)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    ours = Console(quiet=quiet, as_json=False)
    steps = ours.bar("images")((i for i in range(30)), 30)
    assert [time.sleep(0.01) or i for i in steps] == list(range(30))
    assert ("images" in (said := capsys.readouterr().err)) == shown
    assert ("less than a minute left" in said) == (shown and not terminal)
    with ours.steps("fitting") as advance:
        time.sleep(0.2)
        advance(3, 4, 0.5)
    assert (" 3" in (said := capsys.readouterr().err), " left" in said) == (shown, False), said
    with ours.clock("reading"):
        pass
    assert ("reading" in capsys.readouterr().err) == (terminal and not quiet)


def test_info_and_auto_find_one_number(capture, tmp_path, capsys):
    film(capture, change={5: lambda shot: cv2.GaussianBlur(shot, (0, 0), 4)})
    assert run("info", capture, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["frames"], found["layout"], found["points"]) == (24, "colmap", 80)
    assert found["cameras"] == ["PINHOLE 64x48"]
    assert [(bad["name"], bad["kind"]) for bad in found["bad"]] == [("frame_005.jpg", "blurred")]
    assert found["extent"] == pytest.approx(8)
    assert found["agreement"].startswith("reprojection error of median 0.00 px")
    assert found["step"] == pytest.approx(8 * np.sin(np.pi / 24))
    assert found["looked_at"] == pytest.approx([0, 0, 0], abs=1e-9)
    assert run("info", capture) == 0
    printed = capsys.readouterr().out
    assert "(the point closest to all optical axes)" in printed
    assert "blurred   1 frame left out: frame_005.jpg (" in printed
    assert f"keep      {found['enough']} (fsel select -k auto)" in printed
    table = fsel.how_many(capture)
    assert found["how_many"] == json.loads(json.dumps(asdict(table)))
    assert table.total == 23  # without the blurred one
    assert str(table) in printed
    assert select(capture, "-k", "auto", "-o", tmp_path / "out") == 0
    picked = json.loads((tmp_path / "out" / "selection.json").read_text())
    assert found["enough"] == picked["budget"]["reason"]


def test_a_number_of_frames_is_found(capture, tmp_path, capsys):
    out = tmp_path / "out"
    assert select(capture, "-k", "auto", "--targets", "every:6", "-o", out) == 0
    budget = (content := record_of(out))["budget"]
    assert content["settings"]["k"] == "auto"
    assert len(content["frames"]) == budget["frames"] == budget["enough"]
    rule = {"loss": 0.5, "memory": None, "size": [64, 48], "trainer": "splats"}
    assert budget["rule"] == rule
    chosen = fsel.select(fsel.read_capture(capture, long_side=64), "auto", "every:6", patience=0)
    assert budget["table"] == json.loads(json.dumps(asdict(chosen.budget.table)))
    printed = capsys.readouterr().out
    assert budget["reason"] in printed
    assert str(chosen.budget.table) in printed
    report = (out / "report.html").read_text()
    assert budget["reason"] in report
    few = tmp_path / "few"
    assert select(capture, "-k", "auto", "--loss", "10", "-o", few) == 0
    assert len(record_of(few)["frames"]) == min(shipped()["frames"])
    assert 'aria-label="PSNR against all frames"' in (few / "report.html").read_text()


def test_a_number_of_frames_fits_a_gpu(capture, tmp_path, capsys):
    asked = ["-k", "auto", "--vram", "1.2GB"]  # (1.08 - 0.65) / 0.132
    for lacking in (asked, ["-k", "auto", "--trainer", "gsplat"], [*asked[2:], "-k", 4]):
        assert select(capture, *lacking, "-o", tmp_path / "out") == 1
        assert "--vram and --trainer need" in capsys.readouterr().err
    assert select(capture, *asked, "--trainer", "long-lrm", "-o", tmp_path / "out") == 0
    printed = capsys.readouterr().out.splitlines()
    (said,) = [line.split() for line in printed if line.startswith("memory")]
    assert {"3", "long-lrm"} <= set(said)
    content = record_of(tmp_path / "out")
    assert content["budget"]["frames"] == content["budget"]["within"] == len(content["frames"]) == 3
    assert "long-lrm fits into 1,200,000,000 bytes" in content["budget"]["reason"]
    assert content["settings"]["trainer"] == "long-lrm"


def test_two_frames_are_all_worth_keeping(tmp_path, capsys):
    write_ring(tmp_path / "two", frames=2)
    assert run("info", tmp_path / "two", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["enough"] == "all 2 frames: too few to select from"
    assert select(tmp_path / "two", "-k", 2, "-o", tmp_path / "out") == 1
    assert "too few to select from: 2 frames; at least 3" in capsys.readouterr().err


def test_viewing_distance_is_the_median_depth_of_what_is_seen():
    track = capture_of(np.zeros((3, 3)), np.tile(np.eye(3), (3, 1, 1)))
    xyz = np.array([[0.0, 0, 1], [0, 0, 2], [0, 0, 9]])
    seen = SparsePoints(
        xyz, np.zeros((3, 3), np.uint8), np.array([0, 1, 2, 1]), np.array([0] * 3 + [2])
    )
    np.testing.assert_array_equal(viewing_distance(track.views, seen), [2, 2, 2])
    apart = capture_of(
        np.array([[-1.0, 0, 0], [0, 0, 0], [1, 0, 0]]), np.tile(np.eye(3), (3, 1, 1))
    )
    np.testing.assert_allclose(viewing_distance(apart.views, None), 1)  # parallel: no common point


def test_compare_measures_what_the_library_measures(capture, tmp_path, capsys):
    out = tmp_path / "out"
    asked = ["-k", "5,4", "--methods", "fsel,random", "--long-side", 64, "--json", "-o", out]
    assert run("compare", capture, *asked, "--reconstructor", "splats") == 0
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((out / "compare.json").read_text())
    rows = {(row["k"], row["method"]): row for row in content["rows"]}
    assert list(rows) == [(4, "fsel"), (4, "random"), (5, "fsel"), (5, "random")]
    whole = fsel.read_capture(capture, long_side=64)
    held = np.array([0, 8, 16])
    assert content["targets"] == [whole.names[i] for i in held]
    for (k, name), row in rows.items():
        assert row["seeds"] == len(row["picks"]) == (3 if name == "random" else 1)
        found = []
        for names in row["picks"]:
            picks = np.array([whole.names.index(frame) for frame in names])
            assert len(picks) == k
            assert not set(picks) & set(held)
            model = fsel.fit(whole, np.sort(picks))
            found.append(fsel.evaluate(whole, model, held)["psnr"].mean())
        assert row["psnr"] == pytest.approx(np.mean(found), abs=1e-4)
    table = (out / "compare.txt").read_text().splitlines()
    assert table[0].split()[:5] == ["k", "method", "PSNR", "SSIM", "GMSD"]
    command = ["fsel", "select", "--targets", "--patience", "0"]
    assert table[1].split()[:7] == ["4", *command, f"{rows[4, 'fsel']['psnr']:.2f}"]
    gap = rows[4, "fsel"]["psnr"] - rows[4, "random"]["psnr"]
    mean, low, _, high = re.sub("[()*]", "", table[2]).split()[-4:]
    assert float(mean) == pytest.approx(gap, abs=0.006)
    assert float(low) < float(mean) < float(high)
    assert table[-1] == content["verdict"]


def test_compare_picks_as_select_does_fewer_and_more_than_targets(capture, tmp_path):
    out, asked = tmp_path / "out", ["-k", "9,6", "--targets", "every:3", "--methods", "fsel"]
    shown = ["--keep-bad", "--reconstructor", "splats", "--long-side", 48, "-o", out]
    assert run("compare", capture, *asked, *shown) == 0
    rows = json.loads((out / "compare.json").read_text())["rows"]
    for row in rows:
        chosen = fsel.select(capture, row["k"], "every:3", keep_bad=True, patience=0)
        assert row["picks"] == [list(chosen.names)]
    assert not set(rows[0]["picks"][0]) <= set(rows[1]["picks"][0])  # not nested


def test_compare_tries_as_select_does_without_the_held_out_views(capture, tmp_path, quick_trials):
    out, asked = tmp_path / "out", ["-k", 6, "--methods", "tried,fsel,uniform", "--keep-bad"]
    asked += ["--reconstructor", "splats", "--long-side", 48]
    assert run("compare", capture, *asked, "-o", out) == 0
    content = json.loads((out / "compare.json").read_text())
    whole = fsel.read_capture(capture, long_side=48)
    rest = whole.subset(np.setdiff1d(np.arange(24), [0, 8, 16]))
    chosen = fsel.select(rest, 6, keep_bad=True)
    assert content["rows"][0]["picks"] == [list(chosen.names)]
    assert (
        "known to fsel select --targets --patience 0, not to fsel select, uniform."
        in content["how"]
    )


@pytest.mark.parametrize(
    ("stated", "fits", "by"),
    [
        ({}, 18, "gaussians"),
        ({}, 19, "splats"),
        ({"long_side": 384}, 5, "splats"),
        ({"steps": 9}, 99, "gaussians"),
        ({"reconstructor": "splats"}, 1, "splats"),
    ],
)
def test_compare_fits_gaussians_where_they_take_a_minute(stated, fits, by):
    args = Namespace(**{"reconstructor": None, "steps": None, "long_side": 192} | stated)
    settings = compare.judge(args, fits)
    assert args.reconstructor == by
    assert bool(settings) == (by == "gaussians")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--targets", "orbit"], "no photos of these views"),
        (["--methods", "fsel,best"], "method is 'best'"),
        (["-k", "1"], "at least two"),
        (["-k", "10,30"], "k is 30; allowed: 1 to 21"),
    ],
)
def test_compare_refuses_before_it_opens_an_image(
    asked, said, capture, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(image_files, "load", lambda *_: pytest.fail("an image was opened"))
    assert run("compare", capture, "-k", 5, *asked, "-o", tmp_path / "out") == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("targets", [[], ["--targets", "every:8"]])
def test_reconstruct_takes_what_select_wrote(targets, capture, tmp_path, capsys, monkeypatch):
    small = replace(QUALITIES["draft"], long_side=48, gaussians=200, steps=3)
    monkeypatch.setitem(QUALITIES, "draft", small)
    asked = ["-k", 5, "--patience", 0, "--quiet", *targets, "-o", tmp_path / "picked"]
    assert run("select", capture, *asked) == 0
    out = tmp_path / "scene.ply"
    assert run("reconstruct", tmp_path / "picked", "--json", "-o", out) == 0
    picked = (tmp_path / "picked" / "frames.txt").read_text().split()
    said = json.loads(capsys.readouterr().out)
    assert sorted(said["frames"]) == sorted(picked)
    assert (said["reconstructor"], said["steps"]) == ("gaussians", 3)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("frame_003.jpg\nframe_3.jpg\n", "'frame_3.jpg'"),
        ("frame_003.jpg\n", "at least two"),
        ("", "no frame"),
    ],
)
def test_reconstruct_refuses_lists_without_sense(lines, said, capture, tmp_path, capsys):
    (tmp_path / "frames.txt").write_text(lines)
    out = tmp_path / "scene.ply"
    assert run("reconstruct", capture, "--frames", tmp_path / "frames.txt", "-o", out) == 1
    assert said in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"capture", "frames.txt"}
