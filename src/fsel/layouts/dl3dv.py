"""DL3DV: nerfstudio files whose intrinsics are at full resolution though only images_4 ship."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from fsel.layouts import colmap, images, nerfstudio
from fsel.layouts.base import OLD_APPLIED_TRANSFORM, Layout, RawCapture
from fsel.recording import Recording

FACTOR = 4


def _root(folder: Path) -> Path:
    return folder / "nerfstudio" if (folder / "nerfstudio").is_dir() else folder


def recognises(folder: Path) -> bool:
    """transforms.json with downscaled images only."""
    root = _root(folder)
    small = (root / "images_4").is_dir() or (root / "images_8").is_dir()
    return (root / "transforms.json").is_file() and small


def read(folder: Path) -> RawCapture:
    """Either distribution; points from colmap/sparse/0 where it is there."""
    root = _root(folder)
    raw = nerfstudio.from_json(root / "transforms.json", root, undo=OLD_APPLIED_TRANSFORM)
    model = root / "colmap" / "sparse" / "0"
    if not model.is_dir():
        return raw
    reconstruction = colmap.load_model(model)
    rows = {name: i for i, name in enumerate(raw.names)}
    numbered = {
        image.image_id: rows[Path(image.name).name]
        for image in reconstruction.images.values()
        if Path(image.name).name in rows
    }
    return replace(raw, points=partial(colmap.points_of, reconstruction, numbered))


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as the benchmark's nerfstudio folder; frames in arbitrary order."""
    root = folder / "nerfstudio"
    names = [f"{name}.png" for name in recording.names]
    images.write(recording.images, root / "images_4", names)
    camera = colmap.scaled(recording.camera, FACTOR)
    frames = [
        {
            "file_path": f"images/{name}",
            "transform_matrix": nerfstudio.matrix_of(pose, OLD_APPLIED_TRANSFORM),
        }
        for name, pose in zip(names, recording.world_to_camera, strict=True)
    ]
    content = nerfstudio.to_json(camera, "OPENCV")
    content["applied_transform"] = OLD_APPLIED_TRANSFORM.tolist()
    content["frames"] = frames[::2] + frames[1::2]
    (root / "transforms.json").write_text(json.dumps(content))
    model = colmap.build_model(recording, camera, names, np.ones(len(names), bool))
    colmap.write_binary(model, root / "colmap" / "sparse" / "0")


LAYOUT = Layout("dl3dv", recognises, read, write)
