"""`fsel select -k auto`: how many frames, within which memory."""

import pytest
from small_captures import record_of, select

import fsel


def test_a_number_of_frames_is_found(capture, tmp_path, capsys):
    out = tmp_path / "out"
    assert select(capture, "-k", "auto", "--targets", "every:6", "-o", out) == 0
    content = record_of(out)
    budget = content["budget"]
    assert content["settings"]["k"] == "auto"
    assert len(content["frames"]) == budget["frames"] == budget["enough"]
    assert budget["rule"] == {
        "threshold": 0.02,
        "memory": None,
        "size": [64, 48],
        "trainer": "splats",
    }
    whole = fsel.read_capture(capture, long_side=64)
    chosen = fsel.select(whole, "auto", "every:6")
    assert budget["gain"] == pytest.approx(chosen.budget.gain)  # of the points, which were read
    assert [entry["name"] for entry in content["frames"]] == list(chosen.names)
    assert budget["reason"] in capsys.readouterr().out
    assert budget["reason"] in (out / "report.html").read_text()
    assert f"{budget['gain']:.3f} dB" in budget["reason"]


def test_a_number_of_frames_fits_a_gpu(capture, tmp_path, capsys):
    asked = ["-k", "auto", "--vram", "1.2GB"]  # (1.08 - 0.65) / 0.132
    for lacking in (asked, ["-k", "auto", "--trainer", "gsplat"], [*asked[2:], "-k", 4]):
        assert select(capture, *lacking, "-o", tmp_path / "out") == 1
        assert "--vram and --trainer go together" in capsys.readouterr().err
    assert select(capture, *asked, "--trainer", "long-lrm", "-o", tmp_path / "out") == 0
    content = record_of(tmp_path / "out")
    assert content["budget"]["frames"] == content["budget"]["within"] == len(content["frames"]) == 3
    assert "which fit 1,200,000,000 bytes by long-lrm" in content["budget"]["reason"]
    assert content["settings"]["trainer"] == "long-lrm"


def test_methods_that_are_not_nested_find_no_number(capture, tmp_path, capsys):
    assert select(capture, "-k", "auto", "--method", "uniform", "-o", tmp_path / "out") == 1
    assert "method is 'uniform'" in capsys.readouterr().err
