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


def test_a_number_of_frames_fits_the_memory(capture, tmp_path, capsys):
    small = ["--threshold", 1e-6, "--memory", "26kB", "--long-side", 32]  # 24,576 bytes a frame
    assert select(capture, "-k", "auto", *small, "-o", tmp_path / "one") == 1
    assert "memory is 26000 bytes; allowed: 49152 or more" in capsys.readouterr().err
    small[3] = "0.1MB"
    assert select(capture, "-k", "auto", *small, "-o", tmp_path / "out") == 0
    content = record_of(tmp_path / "out")
    assert content["budget"]["frames"] == content["budget"]["within"] == len(content["frames"]) == 4
    assert "fit 100,000 bytes" in content["budget"]["reason"]


def test_a_number_of_frames_fits_a_gpu(capture, tmp_path, capsys):
    asked = ["-k", "auto", "--threshold", 1e-6, "--vram", "1.5GB"]  # (1.35 - 0.65) / 0.132
    for lacking in (asked, ["-k", "auto", "--trainer", "gsplat"]):
        assert select(capture, *lacking, "-o", tmp_path / "out") == 1
        assert "--vram and --trainer go together" in capsys.readouterr().err
    assert select(capture, *asked, "--trainer", "long-lrm", "-o", tmp_path / "out") == 0
    budget = record_of(tmp_path / "out")["budget"]
    assert budget["frames"] == budget["within"] == 5
    assert "which fit 1,500,000,000 bytes by long-lrm" in budget["reason"]
    assert record_of(tmp_path / "out")["settings"]["trainer"] == "long-lrm"


def test_rules_of_a_number_that_is_stated_are_refused(capture, tmp_path, capsys):
    gpu = ["--vram", "8GB", "--trainer", "gsplat"]
    for option in (["--memory", "2GB"], ["--threshold", "0.1"], gpu):
        assert select(capture, "-k", 4, *option, "-o", tmp_path / "out") == 1
        assert "-k auto alone, and k is 4. Hint" in capsys.readouterr().err
    assert select(capture, "-k", "auto", "--method", "uniform", "-o", tmp_path / "out") == 1
    assert "method is 'uniform'" in capsys.readouterr().err
    for wrong in (["-k", "many"], ["-k", "auto", "--memory", "2XB"]):
        with pytest.raises(SystemExit) as stop:
            select(capture, *wrong, "-o", tmp_path / "out")
        assert stop.value.code == 2
