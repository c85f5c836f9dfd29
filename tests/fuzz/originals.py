"""Undamaged inputs of each kind, and the command lines that they are given to."""

import json
import shutil

import cv2
import numpy as np
from layout_recordings import recording, write_film, write_recording
from plyfile import PlyData, PlyElement
from small_captures import camera_path, ring, write_ring

from fsel.captures.read import read_capture
from fsel.reconstruct import ply

FRAMES = 9
WRITTEN = (
    "colmap", "dl3dv", "mipnerf360", "nerfstudio", "scannetpp_dslr", "scannetpp_iphone",
    "seven_scenes", "scannet", "co3d", "tanks_and_temples",
)  # fmt: skip
BESIDE = {"path": "path.json", "masks": "masks", "names": "names.txt", "ply": "model.ply"}
"""Kinds whose damage is in a file or folder beside an undamaged capture."""
KINDS = ("ring", "film", *WRITTEN, "cloud", *BESIDE, "lines")
SIZE = ["--long-side", "128", "--quiet"]  # as `read_capture` has it


def write(folder):
    """A folder a kind: `capture`, with `names.txt` and `model.ply` beside it."""
    for kind in ("ring", "film", *WRITTEN, "cloud"):
        (folder / kind).mkdir(parents=True)
        _write_capture(kind, folder / kind / "capture")
        _write_beside(folder / kind)
    for kind in (*BESIDE, "lines"):
        shutil.copytree(folder / "ring", folder / kind)
    camera_path(folder / "path", ring(4))
    (folder / "masks" / "masks").mkdir()
    for frame in range(FRAMES):
        disc = cv2.circle(np.zeros((48, 64), np.uint8), (32, 24), 10, 255, -1)
        cv2.imwrite(str(folder / "masks" / "masks" / f"frame_{frame:03d}.png"), disc)


def _write_capture(kind, folder):
    if kind == "ring":
        write_ring(folder, frames=FRAMES, cloud=20)
    elif kind == "film":
        write_film(recording("scannetpp_iphone", FRAMES), folder)
    elif kind == "cloud":
        _write_cloud(folder)
    else:
        write_recording(kind, folder, FRAMES)


def _write_cloud(folder):
    """A capture of nerfstudio whose points are a `.ply`, and lie before its cameras."""
    write_recording("nerfstudio", folder, FRAMES)
    path = folder / "transforms.json"
    content = json.loads(path.read_text()) | {"ply_file_path": "cloud.ply", "applied_scale": 0.5}
    path.write_text(json.dumps(content))
    names = [*((axis, "<f8") for axis in "xyz"), *((c, "<f4") for c in ("red", "green", "blue"))]
    rows = np.array([(0, 0, 0.1 * i, 0.1, 0.2, 0.3) for i in range(12)], names)
    PlyData([PlyElement.describe(rows, "vertex")], byte_order="<").write(folder / "cloud.ply")


def _write_beside(folder):
    names = read_capture(folder / "capture").names
    (folder / "names.txt").write_text("\n".join(names[:6:2]) + "\n")
    xyz = np.random.default_rng(0).normal(size=(12, 3))
    ply.write_round(
        folder / "model.ply", xyz, np.full((12, 3), 0.5), np.full(12, 0.5), np.full(12, 0.1)
    )


def commands(kind, folder, rng=None):
    """Name -> words of each command to try, of inputs in `folder`.

    They write to `out` or `out.ply` there. Of those that reconstruct, one drawn; all without `rng`.
    """
    capture, out = str(folder / "capture"), ["-o", str(folder / "out")]
    names, model = str(folder / "names.txt"), str(folder / "model.ply")
    select = ["select", capture, "-k", "3", "--patience", "0", "--quiet", *out]
    every = {
        "compare": ["compare", capture, "-k", "3", "--methods", "uniform", *SIZE, *out],
        "reconstruct": ["reconstruct", capture, "--frames", names, *SIZE, "-o", f"{out[1]}.ply"],
        "render": ["render", model, "--capture", capture, "--targets", "every:8", *SIZE, *out],
    }
    if kind == "path":
        return {"select": [*select, "--targets", str(folder / "path.json")]}
    if kind == "masks":
        # means of nine poses on a circle, which are the targets otherwise, do not see the object
        held = ["--targets", "every:3"]
        return {"select": [*select, "--masks", str(folder / "masks"), *held]}
    if kind == "names":
        return {"select": [*select, "--targets", names], "reconstruct": every["reconstruct"]}
    if kind == "ply":
        return {"render": every["render"]}
    reading = {"select": select, "info": ["info", capture, "--quiet"]}
    if rng is None:
        return reading | every
    further = sorted(every)[rng.integers(len(every))]
    return reading | {further: every[further]}
