"""ScanNet++ v2: the DSLR's fisheye images, and the iPhone's video frames."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from fsel.layouts import colmap, images, nerfstudio
from fsel.layouts.base import (
    OLD_APPLIED_TRANSFORM,
    Layout,
    RawCapture,
    invert_pose,
    read_json,
)
from fsel.recording import Recording


def _with_points(raw: RawCapture, model: Path) -> RawCapture:
    """Add the points of the COLMAP text model beside the images, matched by name."""
    if not (model / "points3D.txt").is_file():
        return raw
    reconstruction = colmap.load_model(model)
    rows = {name: i for i, name in enumerate(raw.names)}
    numbered = {
        image.image_id: rows[Path(image.name).name]
        for image in reconstruction.images.values()
        if Path(image.name).name in rows
    }
    return replace(raw, points=partial(colmap.points_of, reconstruction, numbered))


def _write_text(model, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    model.write_text(str(folder))


def read_dslr(folder: Path) -> RawCapture:
    """dslr/: names are relative to resized_images; bad frames and test frames are left out.

    The poses carry nerfstudio's old world rotation though the file does not say so.
    """
    root = folder / "dslr"
    path = root / "nerfstudio" / "transforms.json"
    raw = nerfstudio.from_json(path, root, prefix="resized_images/", undo=OLD_APPLIED_TRANSFORM)
    tests = [frame["file_path"] for frame in read_json(path).get("test_frames", [])]
    dropped = raw.dropped | dict.fromkeys(tests, "a test frame, never a candidate")
    return _with_points(replace(raw, dropped=dropped), root / "colmap")


def write_dslr(recording: Recording, folder: Path) -> None:
    """Write a recording as a DSLR capture, every 20th frame a test frame."""
    root = folder / "dslr"
    names = [f"{name}.JPG" for name in recording.names]
    images.write(recording.images, root / "resized_images", names)
    frames = [
        {
            "file_path": name,
            "transform_matrix": nerfstudio.matrix_of(pose, OLD_APPLIED_TRANSFORM),
            "is_bad": bool(bad),
        }
        for name, pose, bad in zip(names, recording.world_to_camera, recording.bad, strict=True)
    ]
    content = nerfstudio.to_json(recording.camera, "OPENCV_FISHEYE")
    content["frames"] = [f for i, f in enumerate(frames) if i % 20 != 19]
    content["test_frames"] = frames[19::20]
    (root / "nerfstudio").mkdir(parents=True, exist_ok=True)
    (root / "nerfstudio" / "transforms.json").write_text(json.dumps(content))
    model = colmap.build_model(recording, recording.camera, names, np.ones(len(names), bool))
    _write_text(model, root / "colmap")


def read_iphone(folder: Path) -> RawCapture:
    """iphone/: extracted frames in rgb/, metric poses in pose_intrinsic_imu.json.

    Intrinsics and distortion come from nerfstudio/transforms.json; frames that its COLMAP model
    did not register are left out.
    """
    root = folder / "iphone"
    path = root / "pose_intrinsic_imu.json"
    raw = nerfstudio.from_json(
        root / "nerfstudio" / "transforms.json", root, prefix="rgb/", undo=OLD_APPLIED_TRANSFORM
    )
    metric = read_json(path)
    poses = []
    for name in raw.names:
        entry = metric.get(Path(name).stem)
        if entry is None:
            raise ValueError(f"{path}: no entry for {Path(name).stem}")
        poses.append(invert_pose(np.array(entry["aligned_pose"], float)))
    registered = set(raw.names)
    dropped = {
        f"{stem}.jpg": "not registered by COLMAP"
        for stem in metric
        if f"{stem}.jpg" not in registered
    }
    raw = replace(raw, world_to_camera=np.array(poses), dropped=raw.dropped | dropped)
    return _with_points(raw, root / "colmap")


def write_iphone(recording: Recording, folder: Path) -> None:
    """Write a recording as an iPhone capture whose lost frames COLMAP did not register."""
    root = folder / "iphone"
    names = [f"{name}.jpg" for name in recording.names]
    images.write(recording.images, root / "rgb", names)
    fx, fy, cx, cy = recording.camera.params[:4]
    metric = {}
    for name, pose in zip(recording.names, recording.world_to_camera, strict=True):
        full = np.vstack([invert_pose(pose), [0, 0, 0, 1]]).tolist()
        intrinsic = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]
        metric[name] = {"pose": full, "aligned_pose": full, "intrinsic": intrinsic}
    (root / "pose_intrinsic_imu.json").write_text(json.dumps(metric))
    content = nerfstudio.to_json(recording.camera, "OPENCV")
    content["frames"] = [
        {
            "file_path": names[i],
            "transform_matrix": nerfstudio.matrix_of(
                recording.world_to_camera[i], OLD_APPLIED_TRANSFORM
            ),
        }
        for i in np.flatnonzero(~recording.lost)
    ]
    (root / "nerfstudio").mkdir(parents=True, exist_ok=True)
    (root / "nerfstudio" / "transforms.json").write_text(json.dumps(content))
    model = colmap.build_model(recording, recording.camera, names, ~recording.lost)
    _write_text(model, root / "colmap")


DSLR = Layout(
    "scannetpp_dslr",
    lambda folder: (folder / "dslr" / "nerfstudio" / "transforms.json").is_file(),
    read_dslr,
    write_dslr,
)
IPHONE = Layout(
    "scannetpp_iphone",
    lambda folder: (folder / "iphone" / "pose_intrinsic_imu.json").is_file(),
    read_iphone,
    write_iphone,
)
