"""Selections read by trainers' own parsers, where they are installed."""

import importlib
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from small_captures import select, write_ring

from fsel.captures.read import read_capture
from fsel.core.geometry import OPENGL_TO_OPENCV, invert_pose

GSPLAT = os.environ.get("GSPLAT_EXAMPLES", "")
NERFSTUDIO = os.environ.get("FSEL_NERFSTUDIO", "")
ASK_NERFSTUDIO = """
import json, sys
from pathlib import Path
from nerfstudio.data.dataparsers.nerfstudio_dataparser import NerfstudioDataParserConfig

def told(path, split):
    config = NerfstudioDataParserConfig(
        data=Path(path), orientation_method="none", center_method="none", auto_scale_poses=False,
        load_3D_points=True,
    )
    found = config.setup().get_dataparser_outputs(split)
    cameras = found.cameras
    return {
        "names": [file.name for file in found.image_filenames],
        "poses": cameras.camera_to_worlds.tolist(),
        "size": [int(cameras.width[0]), int(cameras.height[0])],
        "focal": [float(cameras.fx[0]), float(cameras.fy[0])],
        "points": found.metadata["points3D_xyz"].tolist(),
        "colours": found.metadata["points3D_rgb"].tolist(),
    }

parts = ("train", "val", "test")
print(json.dumps([{part: told(path, part) for part in parts} for path in sys.argv[1:]]))
"""


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


@pytest.mark.skipif(
    not NERFSTUDIO, reason="FSEL_NERFSTUDIO names no virtual environment that has nerfstudio"
)
def test_nerfstudio_reads_a_selection_and_its_split(out, tmp_path):
    """Its world is turned by the convention of its axes, and nothing else. The points that a file
    without a COLMAP model beside it names are read as it reads them."""
    (tmp_path / "ask.py").write_text(ASK_NERFSTUDIO)
    asked = [out / "train", out / "transforms_split.json"]
    python = Path(NERFSTUDIO) / "bin" / "python"
    command = [python, tmp_path / "ask.py", *asked]
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, env=clean)
    assert ran.returncode == 0, ran.stderr
    alone, split = json.loads(ran.stdout.splitlines()[-1])
    whole = read_capture(out / "train", "nerfstudio", long_side=64)
    held = [f"frame_{i:03d}.jpg" for i in range(0, 40, 8)]
    for part in ("train", "val", "test"):
        assert alone[part]["names"] == list(whole.names)
        assert split[part]["names"] == (list(whole.names) if part == "train" else held)
    assert (alone["train"]["size"], alone["train"]["focal"]) == ([64, 48], [60.0, 61.0])
    expected = np.array([invert_pose(pose) for pose in whole.world_to_camera])
    expected[:, :, :3] = expected[:, :, :3] @ OPENGL_TO_OPENCV
    np.testing.assert_allclose(alone["train"]["poses"], expected, atol=1e-5)
    (out / "train" / "sparse").rename(tmp_path / "model")
    cloud = read_capture(out / "train", "nerfstudio", long_side=64).points
    for content in (alone, split):
        np.testing.assert_allclose(content["train"]["points"], cloud.xyz, atol=1e-5)
        np.testing.assert_array_equal(content["train"]["colours"], cloud.rgb)
