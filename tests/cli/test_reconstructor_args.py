"""`fsel reconstruct`, `render` and `compare` with a reconstructor that takes steps."""

import json
import signal

import cv2
import numpy as np
import pytest
from small_captures import camera_path, ring, run, write_ring

import fsel
from fsel.captures.images import files as image_files
from fsel.cli.render import file_names
from fsel.core import limits
from fsel.metrics import REGISTERED, Metric, published
from fsel.reconstruct.gaussians import GaussianModel
from fsel.reconstruct.gaussians import settings as quality
from fsel.reconstruct.gaussians.training import Training

SIDE = 32
GAUSSIANS = ["--reconstructor", "gaussians", "--long-side", SIDE]


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("garden") / "capture"
    write_ring(folder)
    return folder


@pytest.fixture
def listed(tmp_path):
    path = tmp_path / "frames.txt"
    path.write_text("".join(f"frame_{i:03d}.jpg\n" for i in (3, 4, 5, 7)))
    return path


@pytest.mark.parametrize("command", ["reconstruct", "compare"])
def test_threads_are_set(command, tmp_path, monkeypatch):
    monkeypatch.setenv(limits.THREADS, "1")
    refused = run(command, tmp_path / "none", "--threads", 3, "-o", tmp_path / "out")
    assert limits.threads() == 3
    assert refused != 0


@pytest.fixture(scope="module")
def ply(capture, tmp_path_factory):
    """A model of eight frames that another trainer might have written."""
    path = tmp_path_factory.mktemp("model") / "garden.ply"
    whole = fsel.read_capture(capture, long_side=SIDE)
    fsel.fit(whole, np.arange(1, 9), "gaussians", steps=20, gaussians=300).export_ply(path)
    return path


def test_gaussians_are_written_after_the_steps_asked_for(capture, listed, tmp_path, capsys):
    out = tmp_path / "scene.ply"
    asked = ["--frames", listed, *GAUSSIANS, "--steps", 4, "--json"]
    assert run("reconstruct", capture, *asked, "-o", out) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["reconstructor"], said["steps"], said["size"]) == ("gaussians", 4, [32, 24])
    assert (said["frames"], said["device"]) == (listed.read_text().split(), "cpu")
    model = GaussianModel.read_ply(out)
    assert model.primitives == said["primitives"] > 0
    assert model.degree == 2


def test_a_quality_says_what_it_takes_and_sets_it(capture, listed, tmp_path, capsys, monkeypatch):
    small = quality.Quality(long_side=48, gaussians=300, steps=20, step=6.0, memory=0.3e9)
    monkeypatch.setitem(quality.QUALITIES, "draft", small)
    out = tmp_path / "scene.ply"
    assert run("reconstruct", capture, "--frames", listed, "--quality", "draft", "-o", out) == 0
    told = capsys.readouterr().out
    what = "images of 48 pixels, 300 Gaussians, 20 steps: about 2 minutes of one core, 0.3 GB"
    assert told.index(what) < told.index("in 20 steps")
    assert 0 < GaussianModel.read_ply(out).primitives <= 300


def test_ctrl_c_writes_the_model_so_far(capture, listed, tmp_path, capsys, monkeypatch):
    made, step, handler = [], Training.step, signal.getsignal(signal.SIGINT)

    def interrupted(self, at):
        made.append(at)
        if at == 2:
            signal.raise_signal(signal.SIGINT)
        return step(self, at)

    monkeypatch.setattr(Training, "step", interrupted)
    out = tmp_path / "scene.ply"
    assert run("reconstruct", capture, "--frames", listed, *GAUSSIANS, "-o", out) == 0
    told = capsys.readouterr()
    assert made == [0, 1, 2]
    assert "in 3 steps" in told.out
    assert "writing the current model" in told.err
    assert GaussianModel.read_ply(out).primitives > 0
    assert signal.getsignal(signal.SIGINT) is handler


def test_ctrl_c_twice_gives_up(capture, listed, tmp_path, capsys, monkeypatch):
    def interrupted(self, at):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Training, "step", interrupted)
    out = tmp_path / "scene.ply"
    assert run("reconstruct", capture, "--frames", listed, *GAUSSIANS, "-o", out) == 130
    assert "nothing was written" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--reconstructor", "nerf"], "reconstructor is 'nerf'; allowed: splats, gaussians"),
        (["--steps", 5], "--steps is 5, but splats takes no steps; allowed with: gaussians"),
        (["--quality", "good", "--steps", 5], "--steps is 5, but --quality good sets it"),
        (["--quality", "good", "--long-side", 64], "--long-side is 64, but --quality good"),
        (["--quality", "good", "--reconstructor", "splats"], "--reconstructor is splats, but"),
        (["--reconstructor", "external"], "'external'; allowed: splats, gaussians, radiance_field"),
        (["--reconstructor", "radiance_field"], "'radiance_field' cannot write a .ply; allowed"),
    ],
)
def test_a_reconstructor_is_refused_before_any_image_is_opened(
    asked, said, capture, listed, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(image_files, "load", lambda *_: pytest.fail("an image was opened"))
    assert run("reconstruct", capture, "--frames", listed, *asked, "-o", tmp_path / "x.ply") == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "x.ply").exists()


def test_a_ply_is_rendered_and_scored_as_the_library_does(capture, ply, tmp_path, capsys):
    out = tmp_path / "rendered"
    asked = ["--capture", capture, "--targets", "every:8", "--long-side", SIDE, "--json"]
    assert run("render", ply, *asked, "-o", out) == 0
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((out / "render.json").read_text())
    whole, held = fsel.read_capture(capture, long_side=SIDE), np.array([0, 8, 16])
    model = GaussianModel.read_ply(ply)
    scores = fsel.evaluate(whole, model, held)
    assert [row["view"] for row in content["views"]] == [whole.names[i] for i in held]
    for name in ("psnr", "ssim", "gmsd"):
        found = [row[name] for row in content["views"]]
        np.testing.assert_allclose(found, scores[name], atol=1e-5)
        assert content["mean"][name] == pytest.approx(np.mean(found), abs=1e-5)
    expected = model.render(whole.view(held))
    for i, image in zip(held, expected, strict=True):
        written = cv2.imread(str(out / "renders" / f"{whole.names[i]}.png"))[..., ::-1]
        np.testing.assert_array_equal(written, np.round(image * 255))
    table = (out / "render.txt").read_text().splitlines()
    assert table[0].split() == ["view", "PSNR", "SSIM", "GMSD"]
    assert table[-1].split()[:2] == ["mean", f"{content['mean']['psnr']:.2f}"]


def test_lpips_takes_the_place_of_gmsd(capture, tmp_path, monkeypatch):
    ones = Metric("lpips", "LPIPS", False, lambda rendered, *_: np.ones(len(rendered)))
    monkeypatch.setitem(REGISTERED, "lpips", ones)
    fetched = []
    monkeypatch.setattr(published, "found", lambda net: None)
    monkeypatch.setattr(published, "fetch", lambda net, path: fetched.append(net))
    out, asked = tmp_path / "out", ["-k", 4, "--methods", "uniform", "--metrics", "psnr,lpips"]
    assert run("compare", capture, *asked, "--long-side", SIDE, "-o", out) == 0
    assert fetched == ["alex"]
    row = json.loads((out / "compare.json").read_text())["rows"][0]
    assert row["lpips"] == 1
    assert "gmsd" not in row


@pytest.mark.parametrize(
    ("given", "said"),
    [(["--metrics", "ssim,lpips"], "psnr, used for ranking"), (["--metrics", "psnr,mae"], "mae")],
)
def test_metrics_are_refused_before_work(given, said, capture, tmp_path, capsys):
    assert run("compare", capture, *given, "-o", tmp_path / "out") == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_no_two_pictures_have_one_name():
    assert file_names(["a/b", "c", "a_b"]) == ["a_b_0000", "c_0001", "a_b_0002"]
    assert file_names(["A.png", "a.png"]) == ["A.png_0000", "a.png_0001"]
    assert file_names(["x/1", "y/1"]) == ["x_1", "y_1"]


def test_views_without_truth_are_rendered_and_not_scored(capture, ply, tmp_path):
    path = camera_path(tmp_path, ring(24)[:2])
    out = tmp_path / "rendered"
    asked = ["--capture", capture, "--targets", path, "--long-side", SIDE]
    assert run("render", ply, *asked, "-o", out) == 0
    assert json.loads((out / "render.json").read_text())["mean"] is None
    assert sorted(p.name for p in (out / "renders").iterdir()) == ["view_000.png", "view_001.png"]


def test_compare_asks_another_reconstructor_about_the_same_picks(capture, tmp_path, capsys):
    asked = ["-k", "4", "--methods", "fsel,uniform", "--json", "--long-side", SIDE]
    found = {}
    for name, more in {"splats": [], "gaussians": ["--steps", 3]}.items():
        own = ["--reconstructor", name, *more, "-o", tmp_path / name]
        assert run("compare", capture, *asked, *own) == 0
        found[name] = json.loads(capsys.readouterr().out)
        assert found[name]["reconstructor"] == name
    splats, gaussians = (found[name]["rows"] for name in found)
    assert [row["picks"] for row in splats] == [row["picks"] for row in gaussians]
    assert all(one["psnr"] != other["psnr"] for one, other in zip(splats, gaussians, strict=True))
