"""Selections read by trainers' own parsers, where they are installed."""

import importlib
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from small_captures import select, write_ring

from fsel.layouts import read_capture

GSPLAT = os.environ.get("GSPLAT_EXAMPLES", "")


@pytest.fixture
def out(tmp_path):
    write_ring(tmp_path / "capture", frames=40)
    asked = ["-k", 12, "--targets", "every:8", "-o", tmp_path / "out"]
    assert select(tmp_path / "capture", *asked) == 0
    return tmp_path / "out"


@pytest.mark.skipif(not GSPLAT, reason="GSPLAT_EXAMPLES names no copy of gsplat's examples")
def test_gsplat_reads_a_selection(out, monkeypatch):
    monkeypatch.syspath_prepend(GSPLAT)
    parser = importlib.import_module("datasets.colmap").Parser
    whole = read_capture(out / "train", "colmap", long_side=64)
    plain = parser(str(out / "train"), factor=1, normalize=False)
    assert plain.image_names == list(whole.names)
    found = np.linalg.inv(plain.camtoworlds)[:, :3]
    np.testing.assert_allclose(found, whole.world_to_camera, atol=1e-9)
    normal = parser(str(out / "train"), factor=1, normalize=True)
    assert len(normal.points) == len(whole.points.xyz)


def nerfstudio(path):
    parsers = pytest.importorskip(
        "nerfstudio.data.dataparsers.nerfstudio_dataparser",
        reason="nerfstudio is not installed",
    )
    config = parsers.NerfstudioDataParserConfig(
        data=Path(path), orientation_method="none", center_method="none", auto_scale_poses=False
    )
    parser = config.setup()
    return {split: parser.get_dataparser_outputs(split) for split in ("train", "val", "test")}


@pytest.mark.filterwarnings("ignore")
def test_nerfstudio_reads_a_selection_and_its_split(out):
    """Its world is turned by the convention of its axes, and nothing else."""
    whole = read_capture(out / "train", "nerfstudio", long_side=64)
    found = nerfstudio(out / "train")["train"]
    assert [path.name for path in found.image_filenames] == list(whole.names)
    assert len(found.metadata["points3D_xyz"]) == len(whole.points.xyz)
    split = nerfstudio(out / "transforms_split.json")
    assert [path.name for path in split["train"].image_filenames] == list(whole.names)
    held = [f"frame_{i:03d}.jpg" for i in range(0, 40, 8)]
    for part in ("val", "test"):
        assert [path.name for path in split[part].image_filenames] == held
    assert len(split["train"].metadata["points3D_xyz"]) == len(whole.points.xyz)
    sizes = found.cameras
    assert (int(sizes.width[0]), int(sizes.height[0]), float(sizes.fx[0])) == (64, 48, 60)
    assert "nerfstudio" in sys.modules
