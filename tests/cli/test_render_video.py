"""`fsel render --video`: what is written, what is refused, and flights through the frames."""

import json

import cv2
import numpy as np
import pytest
from selection_problems import around
from small_captures import ring, write_ring

from fsel.cli import main
from fsel.cli.render import between, flight
from fsel.reconstruct import ply

CIRCLE = around(ring(24))


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


def test_a_flight_passes_through_its_views_at_an_even_speed():
    known = CIRCLE.view(np.arange(9))
    flown = between(known, 161)
    np.testing.assert_allclose(flown.world_to_camera[::20], known.world_to_camera, atol=1e-9)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert ways.max() < 1.1 * ways.min()
    np.testing.assert_allclose(np.linalg.det(flown.world_to_camera[:, :, :3]), 1)
    np.testing.assert_allclose(np.linalg.norm(flown.centers, axis=1), 17**0.5, rtol=5e-3)


def test_a_flight_takes_no_time_for_no_way_and_stands_still_at_one_view():
    poses = ring(24)[[0, 0, 3, 3, 6]]
    flown = between(around(poses).views, 101)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert (ways < 1e-6).sum() <= 12
    for still in (poses[:1], poses[:2]):
        same = between(around(still).views, 5)
        np.testing.assert_allclose(same.world_to_camera, poses[[0] * 5], atol=1e-12)


@pytest.mark.parametrize("request_", ["orbit", "trajectory", "every:8", [3, 9]])
def test_views_are_as_many_and_as_large_as_asked_and_see_the_same(request_):
    flown = flight(CIRCLE, request_, 100, 1280)
    assert (len(flown), flown.size) == (100, (1280, 960))
    np.testing.assert_allclose(flown.intrinsics, np.tile(CIRCLE.intrinsics[0] * 20, (100, 1)))
