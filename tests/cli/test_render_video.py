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
    """A capture and two models of one Gaussian, red and blue."""
    monkeypatch.chdir(tmp_path)
    write_ring(tmp_path / "ring")
    for name, rgb in {"red": [[1.0, 0, 0]], "blue": [[0, 0, 1.0]]}.items():
        ply.write_round(f"{name}.ply", np.zeros((1, 3)), np.array(rgb), np.ones(1), np.ones(1))
    return tmp_path


def film(*arguments):
    return main(["render", "red.ply", "--capture", "ring", "--targets", *arguments])


def frames_of(path):
    video = cv2.VideoCapture(str(path))
    return [video.read()[1] for _ in range(int(video.get(cv2.CAP_PROP_FRAME_COUNT)))]


def test_a_flight_between_frames_of_two_models(made, capsys):
    (made / "other").mkdir()
    (made / "blue.ply").rename("other/red.ply")  # of the same name as the first
    sizes = ["--long-side", "120", "--seconds", "0.4", "--side-by-side", "other/red.ply"]
    assert film("every:8", "--video", "a.mp4", *sizes, "--json") == 0
    assert json.loads(capsys.readouterr().out)["size"] == [120, 90]
    frames = frames_of("a.mp4")
    assert len(frames) == 12
    assert frames[0].shape[1] == 240
    for frame in frames:
        left, right = (half[20:].mean(axis=(0, 1)) for half in (frame[:, :120], frame[:, 120:]))
        assert left[2] > 3 * left[0]
        assert right[0] > 3 * right[2]


def test_a_video_is_replaced_by_force_alone(made):
    given = ["orbit", "--video", "a.mp4", "--long-side", "64", "--seconds", "0.1"]
    assert film(*given) == 0
    assert len(frames_of("a.mp4")) == 3
    assert film(*given) == 1
    (made / "a.mp4").write_bytes(b"")
    assert film(*given, "--force") == 0
    assert len(frames_of("a.mp4")) == 3


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--video", "a.avi"], "a.avi: a video is written as .mp4"),
        (["--video", "a.mp4", "--metrics", "psnr"], "--metrics compares renderings with frames"),
        (["-o", "out", "--side-by-side", "blue.ply"], "--side-by-side is of a video"),
        (["--video", "a.mp4", "--side-by-side", "gone.ply"], "gone.ply: No such file"),
    ],
)
def test_what_does_not_fit_is_refused(given, said, made, capsys):
    assert film("orbit", *given) == 1
    assert said in capsys.readouterr().err
    assert not (made / "a.mp4").exists()
