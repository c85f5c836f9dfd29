"""DL3DV: nerfstudio files whose intrinsics are at full resolution though only images_4 ship.

The benchmark holds two distributions of a scene, `nerfstudio` (distorted images) and
`gaussian_splat` (COLMAP, undistorted); their poses and cameras do not mix. The 10K release and its
sample hold the first alone.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from fsel.captures.colmap.model import write_binary
from fsel.captures.images import files as image_files
from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.layouts.contract import Layout, RawCapture, Recording

FACTOR = 4
COPIES = ("images_4", "images_8")  # of images in 4K, which take half a second each to open
SPLATS = "gaussian_splat"


def _root(folder: Path) -> Path | None:
    """The folder of transforms.json with downscaled images: the scene's own, or one inside."""
    for root in (folder / "nerfstudio", folder / "colmap", folder):
        small = (root / "images_4").is_dir() or (root / "images_8").is_dir()
        if (root / "transforms.json").is_file() and small:
            return root
    return None


def recognises(folder: Path) -> bool:
    """Downscaled images with transforms.json, or gaussian_splat alone."""
    splats = (folder / SPLATS / "sparse" / "0").is_dir()
    return _root(folder) is not None or splats


def read(folder: Path) -> RawCapture:
    """Either distribution, `nerfstudio` where both ship; points from its colmap/sparse/0."""
    root = _root(folder)
    if root is None and (folder / SPLATS).is_dir():
        return colmap.read(folder / SPLATS)
    if root is None:
        raise FileNotFoundError(
            f"{folder}: no transforms.json with images_4 or images_8, and no {SPLATS}; some scenes "
            "of the release have none: leave this one out"
        )
    raw = nerfstudio.from_json(
        root / "transforms.json", root, undo=nerfstudio.OLD_APPLIED_TRANSFORM, copies=COPIES
    )
    model = root / "colmap" / "sparse" / "0"
    return colmap.with_points(raw, model) if model.is_dir() else raw


def frame_order(folder: Path) -> list[str]:
    """Names of the images in the order of a scene's transforms.json.

    Raises:
        FileNotFoundError: for a folder without it.
    """
    root = _root(folder)
    if root is None:
        raise FileNotFoundError(f"{folder}: no transforms.json with images_4 or images_8")
    content = json.loads((root / "transforms.json").read_text())
    return [Path(frame["file_path"]).name for frame in content["frames"]]


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as the benchmark's nerfstudio folder; frames in arbitrary order."""
    root = folder / "nerfstudio"
    names = [f"{name}.png" for name in recording.names]
    image_files.write(recording.images, root / "images_4", names)
    camera = colmap.scaled(recording.camera, FACTOR)
    content = nerfstudio.scene_of(recording, camera, names, nerfstudio.OLD_APPLIED_TRANSFORM)
    (root / "transforms.json").write_text(json.dumps(content))
    model = colmap.build_model(recording, camera, names, np.ones(len(names), bool))
    write_binary(model, root / "colmap" / "sparse" / "0")


LAYOUT = Layout("dl3dv", recognises, read, write)
