"""`fsel render --video`: what is written, and what is refused."""

import json

import cv2
import numpy as np
import pytest
from small_captures import write_ring

from fsel.cli import main
from fsel.reconstruct import ply


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A capture and a model of one red Gaussian."""
    monkeypatch.chdir(tmp_path)
    write_ring(tmp_path / "ring")
    red = np.array([[1.0, 0, 0]])
    ply.write_round("red.ply", np.zeros((1, 3)), red, np.ones(1), np.ones(1))
    return tmp_path


def film(*arguments):
    return main(["render", "red.ply", "--capture", "ring", "--targets", *arguments])


def frames_of(path):
    video = cv2.VideoCapture(str(path))
    return [video.read()[1] for _ in range(int(video.get(cv2.CAP_PROP_FRAME_COUNT)))]


def test_a_flight_between_frames_of_a_model(made, capsys):
    sizes = ["--long-side", "120", "--seconds", "0.4"]
    assert film("every:8", "--video", "a.mp4", *sizes, "--json") == 0
    assert json.loads(capsys.readouterr().out)["size"] == [120, 90]
    frames = frames_of("a.mp4")
    assert len(frames) == 12
    for frame in frames:
        assert frame.shape == (90, 120, 3)
        blue, _, red = frame.mean(axis=(0, 1))
        assert red > 3 * blue


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--video", "a.avi"], "a.avi: a video must be a .mp4 file"),
        (["--video", "a.mp4", "--metrics", "psnr"], "--metrics scores renderings of frames"),
    ],
)
def test_what_does_not_fit_is_refused(given, said, made, capsys):
    assert film("orbit", *given) == 1
    assert said in capsys.readouterr().err
    assert not (made / "a.mp4").exists()


def test_a_model_without_gaussians_is_not_scored(made, capsys):
    nothing = np.zeros((0, 3))
    ply.write_round("red.ply", nothing, nothing, nothing[:, 0], nothing[:, 0])
    assert film("every:8", "-o", "out") == 1
    assert "red.ply: contains no Gaussians" in capsys.readouterr().err
    assert not (made / "out").exists()
