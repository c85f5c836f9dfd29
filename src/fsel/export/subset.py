"""A selection as a capture that trainers read: images, transforms.json, a COLMAP model."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pycolmap

from fsel.layouts import images
from fsel.layouts.base import RawPoints
from fsel.layouts.nerfstudio import matrix_of
from fsel.opening import Opened
from fsel.recording import Camera

WRITTEN = ("transforms.json", "sparse_pc.ply", "images", "sparse")
LEAST_TRACK = 2  # selected frames that see a point: fewer could not have triangulated it
DISTORTION = {
    **dict.fromkeys(("SIMPLE_PINHOLE", "PINHOLE"), ()),
    "SIMPLE_RADIAL": ("k1",),
    "RADIAL": ("k1", "k2"),
    "OPENCV": ("k1", "k2", "p1", "p2"),
    "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4"),
}


def write(stage: Path, opened: Opened, picks: np.ndarray, held: np.ndarray, copy: bool) -> None:
    """Write the subset.

    The COLMAP model and the points know the picked frames alone. Held-out frames come with their
    images and poses, for evaluation; no other frame leaves a trace.

    Args:
        stage: folder to fill.
        opened: the capture.
        picks: (k,) frames to train on.
        held: (F,) frames to evaluate on; where there are none, the picked ones stand in, since
            nerfstudio refuses empty lists.
        copy: copy the images; else hard links, where the file system has them.

    Raises:
        ValueError: for a frame whose name leads out of the folder, or an unreadable image.
    """
    train, held = np.sort(picks), np.sort(held)
    used = np.concatenate([train, held])
    names = {int(i): _file_name(opened, i) for i in used}
    for i, name in names.items():
        _place(opened.files[i], _inside(stage / "images", name), copy)
    cameras = dict(zip(names, _true_cameras(opened, used), strict=True))
    points = opened.points()
    model = _model(opened, train, names, cameras, points)
    (stage / "sparse" / "0").mkdir(parents=True)
    model.write_binary(str(stage / "sparse" / "0"))
    content = _transforms(opened, train, held, names, cameras)
    if model.points3D:
        model.export_PLY(str(stage / "sparse_pc.ply"))
        content["ply_file_path"] = "sparse_pc.ply"
    (stage / "transforms.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def _file_name(opened: Opened, frame: int) -> str:
    """Name of the frame's image below `images`, with the ending that its file has."""
    name, ending = opened.capture.names[frame], opened.files[frame].suffix
    return name if Path(name).suffix.lower() == ending.lower() else f"{name}{ending}"


def _inside(folder: Path, name: str) -> Path:
    path = Path(os.path.normpath(folder / name))
    if not path.is_relative_to(folder):
        raise ValueError(f"frame {name!r}: its name leads out of the folder that it is written to")
    return path


def _place(file: Path, path: Path, copy: bool) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not copy:
        try:
            os.link(file.resolve(), path)
        except OSError:
            copy = True  # another file system, or one without hard links
    if copy:
        shutil.copy2(file, path)


def _true_cameras(opened: Opened, frames: Sequence[int]) -> list[Camera]:
    """Cameras at the size that their images have, one image of each camera being opened."""
    true: dict[Camera, Camera] = {}
    for i in frames:
        camera = opened.cameras[i]
        if camera not in true:
            height, width = images.load(opened.files[i]).shape[:2]
            scaled = _colmap_camera(camera)
            scaled.rescale(width, height)
            true[camera] = Camera(camera.model, width, height, tuple(scaled.params))
    return [true[opened.cameras[i]] for i in frames]


def _colmap_camera(camera: Camera, number: int = 1) -> pycolmap.Camera:
    return pycolmap.Camera(
        camera_id=number,
        model=camera.model,
        width=camera.width,
        height=camera.height,
        params=list(camera.params),
    )


def _model(
    opened: Opened,
    frames: np.ndarray,
    names: dict[int, str],
    cameras: dict[int, Camera],
    points: RawPoints | None,
) -> pycolmap.Reconstruction:
    """The frames, and the points that two or more of them see; observations are projections."""
    model = pycolmap.Reconstruction()
    numbers = {camera: n for n, camera in enumerate(dict.fromkeys(cameras[i] for i in frames), 1)}
    for camera, number in numbers.items():
        model.add_camera_with_trivial_rig(_colmap_camera(camera, number))
    seen = _tracks(points, frames)
    tracks: dict[int, pycolmap.Track] = {}
    for number, i in enumerate(frames, 1):
        pose = opened.capture.world_to_camera[i]
        camera = model.cameras[numbers[cameras[i]]]
        keypoints = np.empty((0, 2))
        if points is not None:
            keypoints = camera.img_from_cam(points.xyz[seen[i]] @ pose[:, :3].T + pose[:, 3])
        image = pycolmap.Image(
            image_id=number,
            name=names[i],
            camera_id=camera.camera_id,
            keypoints=np.asarray(keypoints, np.float64),
        )
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        model.add_image_with_trivial_frame(image, rigid)
        for row, point in enumerate(seen[i]):
            tracks.setdefault(int(point), pycolmap.Track()).add_element(number, row)
    for point in sorted(tracks):
        model.add_point3D(points.xyz[point], tracks[point], points.rgb[point])
    return model


def _tracks(points: RawPoints | None, frames: np.ndarray) -> dict[int, np.ndarray]:
    """Frame -> the points it sees, of those that enough of the frames see."""
    if points is None:
        return {int(i): np.empty(0, np.int64) for i in frames}
    used = np.isin(points.track_frame, frames)
    pairs = np.unique(np.stack([points.track_frame[used], points.track_point[used]]), axis=1)
    enough = np.bincount(pairs[1], minlength=len(points.xyz)) >= LEAST_TRACK
    pairs = pairs[:, enough[pairs[1]]]
    return {int(i): pairs[1, pairs[0] == i] for i in frames}


def _transforms(
    opened: Opened,
    train: np.ndarray,
    held: np.ndarray,
    names: dict[int, str],
    cameras: dict[int, Camera],
) -> dict:
    """nerfstudio's transforms.json; the world is the capture's own."""
    paths = {i: f"images/{name}" for i, name in names.items()}
    frames = [
        {
            "file_path": paths[i],
            "transform_matrix": matrix_of(opened.capture.world_to_camera[i], np.eye(4)[:3]),
        }
        for i in sorted(names)
    ]
    intrinsics = {i: _intrinsics(camera) for i, camera in cameras.items()}
    shared = intrinsics[int(train[0])]
    if any(values != shared for values in intrinsics.values()):
        frames = [frame | intrinsics[i] for frame, i in zip(frames, sorted(names), strict=True)]
        shared = {"camera_model": shared["camera_model"]}
    tested = held if len(held) else train
    return {
        **shared,
        "train_filenames": [paths[i] for i in train.tolist()],
        "val_filenames": [paths[i] for i in tested.tolist()],
        "test_filenames": [paths[i] for i in tested.tolist()],
        "frames": frames,
    }


def _intrinsics(camera: Camera) -> dict:
    simple = camera.model in ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL")
    params = (camera.params[0], *camera.params) if simple else camera.params
    keys = ("fl_x", "fl_y", "cx", "cy", *DISTORTION[camera.model])
    fisheye = camera.model == "OPENCV_FISHEYE"
    return {
        "camera_model": "OPENCV_FISHEYE" if fisheye else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        **dict(zip(keys, params, strict=True)),
    }
