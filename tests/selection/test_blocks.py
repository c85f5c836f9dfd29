"""Blocks of a large scene."""

import json
from dataclasses import replace

import numpy as np
import pytest
import small_captures
from selection_problems import around
from small_captures import select

from fsel.captures.lazy import open_capture
from fsel.selection import blocks
from fsel.selection.blocks import blocks_of


def arcs(frames, count):
    """How many stretches of a ring some of its frames make."""
    return int(np.sum(np.diff(np.sort(frames), append=np.min(frames) + count) > 1))


@pytest.mark.parametrize(("points", "enough"), [(True, 6000), (True, 1500), (False, 6000)])
def test_blocks_of_a_ring_are_arcs_that_overlap(points, enough, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "ENOUGH", enough)
    small_captures.write_ring(tmp_path / "ring", frames=60, cloud=300)
    capture = open_capture(tmp_path / "ring").with_all_points()
    capture = capture if points else replace(capture, points=None)
    found = blocks_of(capture, 3)
    assert set(np.concatenate(found).tolist()) == set(range(60))
    assert [len(block) for block in found] == [24, 24, 24]  # 20 of its own, 4 of its neighbours
    assert [arcs(block, 60) for block in found] == [1, 1, 1]
    for block, other in zip(found, [*found[1:], found[0]], strict=True):
        assert len(np.intersect1d(block, other)) > 1


def test_more_blocks_than_frames_are_refused():
    with pytest.raises(ValueError, match="blocks is 4; allowed: 2 to 3"):
        blocks_of(around(small_captures.ring(12)), 4)


def test_every_block_is_a_selection_and_names_what_it_shares(tmp_path, capsys):
    small_captures.write_ring(tmp_path / "ring", frames=40)
    out, asked = tmp_path / "out", ["-k", 8, "--blocks", 2, "--patience", 0]
    assert select(tmp_path / "ring", *asked, "-o", out) == 0
    first, second = json.loads((out / "blocks.json").read_text())["blocks"]
    both = sorted(set(first["picks"]) & set(second["picks"]))
    assert both
    assert sorted(first["shared"]["block_2"]) == sorted(second["shared"]["block_1"]) == both
    assert set(first["frames"]) | set(second["frames"]) == {f"frame_{i:03d}.jpg" for i in range(40)}
    for block in (first, second):
        folder = out / block["folder"]
        assert (folder / "frames.txt").read_text().split() == block["picks"]
        assert sorted((folder / "shared.txt").read_text().split()) == both
        assert open_capture(folder).capture.names == tuple(sorted(block["picks"]))
    assert select(tmp_path / "ring", *asked, "--targets", "orbit", "-o", out) == 1
    assert "--targets" in capsys.readouterr().err
