"""Images with a whole header and damaged contents: refused where they are decoded, not exported."""

import pytest
from small_captures import damage_pixels, select, write_ring

from fsel.captures.read import read_capture
from fsel.cli import main

NAME = "frame_008.jpg"
SAID = f"{NAME}: not a readable image: its "


@pytest.fixture
def capture(tmp_path):
    write_ring(tmp_path / "capture")
    damage_pixels(tmp_path / "capture" / "images" / NAME)
    (tmp_path / "names.txt").write_text(f"{NAME}\n")
    return tmp_path / "capture"


@pytest.mark.parametrize("more", [[], ["--geometry-only"], ["--long-side", 32]])
@pytest.mark.parametrize("how", [["--always", "names.txt"], ["--targets", "every:4"]])
def test_no_damaged_frame_is_exported(more, how, capture, tmp_path, monkeypatch, capsys):
    """Neither as a pick nor held out: every fourth frame is one of those."""
    monkeypatch.chdir(tmp_path)
    assert select(capture, "-k", 4, *how, *more, "-o", "out") == 1
    printed = capsys.readouterr().err
    assert SAID in printed
    assert "--skip-unreadable" in printed
    assert "--never" in printed
    assert not (tmp_path / "out").exists()


def test_what_does_not_decode_it_takes_it_and_the_others_say_the_same(capture, tmp_path, capsys):
    assert select(capture, "-k", 3, "--never", tmp_path / "names.txt", "-o", tmp_path / "out") == 0
    capsys.readouterr()
    (tmp_path / "two.txt").write_text(f"frame_007.jpg\n{NAME}\n")
    asked = ["reconstruct", capture, "--frames", tmp_path / "two.txt", "--long-side", 48]
    assert main([*map(str, asked), "-o", str(tmp_path / "out.ply")]) == 1
    said = capsys.readouterr().err
    assert SAID in said
    with pytest.raises(ValueError, match=SAID) as refused:
        read_capture(capture, long_side=48)
    assert f"fsel: {refused.value}\n" in said
    assert len(read_capture(capture, long_side=48, skip_unreadable=True)) == 23
