"""A capture of which frames were selected, opened again."""

import json

import numpy as np
import pytest
from small_captures import write_ring

from fsel.cli import main, open_capture
from fsel.reconstruct import ply


@pytest.fixture
def picked(tmp_path):
    """A selection whose record says that its capture was a video, placed with another's frames."""
    write_ring(tmp_path / "ring")
    asked = ["-k", "5", "--patience", "0", "--quiet"]
    assert main(["select", str(tmp_path / "ring"), *asked, "-o", str(tmp_path / "picked")]) == 0
    return tmp_path / "picked"


@pytest.fixture
def opened(picked, monkeypatch):
    """Command lines whose captures were to be opened."""
    file, given = picked / "selection.json", []
    record = json.loads(file.read_text())
    assert record["capture"]["opened"]["layout"] == "auto"
    record["capture"]["opened"] |= {"poses": "colmap", "rate": 2.0}
    record["capture"]["beside"] = [str(picked.parent / "second.mp4")]
    file.write_text(json.dumps(record))
    monkeypatch.setattr(open_capture, "opened", lambda args, *_: given.append(args) or 1 / 0)
    return given


@pytest.mark.parametrize("command", ["view", "reconstruct", "render", "render --video"])
@pytest.mark.parametrize("stated", [True, False])
def test_a_capture_is_opened_as_the_selection_did_unless_stated(command, stated, picked, opened):
    ring, more = picked.parent / "ring", ["--rate", "3"] if stated else []
    model, out = picked.parent / "model.ply", picked.parent / "out"
    one = np.ones((1, 3))
    ply.write_round(model, one, one, one[:, 0], one[:, 0])
    words = {
        "view": ["view", picked, "-o", f"{out}.html"],
        "reconstruct": ["reconstruct", ring, "--frames", picked / "frames.txt", "-o", f"{out}.ply"],
        "render": ["render", model, "--capture", picked, "--targets", "orbit", "-o", out],
    }
    words["render --video"] = [*words["render"][:-2], "--video", f"{out}.mp4"]
    with pytest.raises(ZeroDivisionError):
        main([*map(str, words[command]), *more])
    (args,) = opened
    assert args.capture == ring
    if stated:
        assert (args.poses, args.rate, args.beside) == ("layout", 3.0, [])
    else:
        assert (args.poses, args.rate, args.k) == ("colmap", 2.0, 5)
        assert args.beside == [picked.parent / "second.mp4"]


def test_the_frames_of_another_capture_say_nothing_of_how_this_one_is_opened(picked, opened):
    write_ring(picked.parent / "other")
    asked = ["--frames", str(picked / "frames.txt"), "-o", str(picked.parent / "out.ply")]
    with pytest.raises(ZeroDivisionError):
        main(["reconstruct", str(picked.parent / "other"), *asked])
    assert opened[0].rate is None
