"""A selection as a capture that trainers read: images, transforms.json, a COLMAP model."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pycolmap

from fsel.layouts import images
from fsel.layouts.base import RawCapture, RawPoints
from fsel.layouts.nerfstudio import matrix_of
from fsel.layouts.opening import Opened
from fsel.layouts.recording import Camera
from fsel.request.focus import load_white, mask_file

NO_POINTS = RawPoints(
    xyz=np.empty((0, 3)),
    rgb=np.empty((0, 3), np.uint8),
    track_point=np.empty(0, np.int64),
    track_frame=np.empty(0, np.int64),
    track_xy=np.empty((0, 2)),
)
LEAST_TRACK = 2  # selected frames that see a point: fewer could not have triangulated it
FILM = ".jpg"  # ending of images that are frames of a video
SIMPLE = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")
DISTORTION = {
    **dict.fromkeys(("SIMPLE_PINHOLE", "PINHOLE"), ()),
    **dict.fromkeys(("SIMPLE_RADIAL", "SIMPLE_RADIAL_FISHEYE"), ("k1",)),
    **dict.fromkeys(("RADIAL", "RADIAL_FISHEYE"), ("k1", "k2")),
    "OPENCV": ("k1", "k2", "p1", "p2"),
    "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4"),
}
"""Camera models that nerfstudio has too, and its names of their coefficients."""


def check_cameras(raw: RawCapture) -> None:
    """Refuse, before any work, cameras that transforms.json cannot state.

    Raises:
        ValueError: for a camera model that nerfstudio does not have.
    """
    for camera in raw.cameras:
        if camera.model not in DISTORTION:
            raise ValueError(
                f"camera model {camera.model} has no counterpart in transforms.json; allowed: "
                f"{', '.join(DISTORTION)}. Hint: undistort the capture first (colmap "
                "image_undistorter)"
            )


def write(
    stage: Path,
    opened: Opened,
    picks: np.ndarray,
    held: np.ndarray,
    copy: bool,
    shapes: Path | None = None,
) -> None:
    """Write the subset.

    The COLMAP model and the points know the picked frames alone. Held-out frames come with their
    images and poses, for evaluation; no other frame is written. Where there are masks, of the
    object or else the capture's own, each image gets one of its size, white where pixels count.

    Args:
        stage: folder to fill.
        opened: the capture, its cameras checked by `check_cameras`.
        picks: (k,) frames to train on.
        held: (F,) frames to evaluate on; where there are none, the picked ones stand in, since
            nerfstudio refuses empty lists.
        copy: copy the images; else hard links, where the file system has them.
        shapes: folder of an object's masks; a frame without one shows nothing of it.

    Raises:
        ValueError: for a frame whose name leads out of the folder, or an unreadable image.
    """
    train, kept_back = np.sort(picks).tolist(), np.sort(held).tolist()
    used = sorted(train + kept_back)
    names = {i: _file_name(opened.raw, i) for i in used}
    for i, name in names.items():
        _place(opened.raw.images[i], _inside(stage / "images", name), copy)
    cameras = dict(zip(used, _true_cameras(opened.raw, used), strict=True))
    model = _model(opened.raw.subset(train), [names[i] for i in train], [cameras[i] for i in train])
    (stage / "sparse" / "0").mkdir(parents=True)
    model.write_binary(str(stage / "sparse" / "0"))
    content = _transforms(opened, train, kept_back, names, cameras)
    if shapes is not None or opened.raw.masks is not None:
        for frame, (i, name) in zip(content["frames"], sorted(names.items()), strict=True):
            mask = _mask(opened.raw, i, shapes, (cameras[i].width, cameras[i].height))
            images.write(mask[None], stage / "masks", [f"{name}.png"])
            frame["mask_path"] = f"masks/{name}.png"
    if model.points3D:
        model.export_PLY(str(stage / "sparse_pc.ply"))
        content["ply_file_path"] = "sparse_pc.ply"
    (stage / "transforms.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def _file_name(raw: RawCapture, frame: int) -> str:
    """Name of the frame's image below `images`, with the ending that its file has."""
    name, file = raw.names[frame], raw.images[frame]
    ending = FILM if isinstance(file, images.VideoFrame) else file.suffix
    return name if Path(name).suffix.lower() == ending.lower() else f"{name}{ending}"


def _inside(folder: Path, name: str) -> Path:
    path = Path(os.path.normpath(folder / name))
    if not path.is_relative_to(folder):
        raise ValueError(f"frame {name!r}: its name leads out of the folder that it is written to")
    return path


def _place(file: images.Image, path: Path, copy: bool) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(file, images.VideoFrame):
        images.write(images.load(file)[None], path.parent, [path.name])
        return
    if not copy:
        try:
            os.link(file.resolve(), path)
        except OSError:
            copy = True  # another file system, or one without hard links
    if copy:
        shutil.copy2(file, path)


def _mask(raw: RawCapture, frame: int, shapes: Path | None, size: tuple[int, int]) -> np.ndarray:
    """(h, w) uint8 0 or 255 at (width, height) `size`."""
    mask = np.zeros(size[::-1], bool)
    if shapes is not None:
        file = mask_file(shapes, raw.names[frame])
        mask = load_white(file) if file else mask
    elif raw.masks is not None:
        mask = images.load_mask(raw.masks[frame], raw.mask_values)
    return cv2.resize(mask.astype(np.uint8) * 255, size, interpolation=cv2.INTER_NEAREST_EXACT)


def _true_cameras(raw: RawCapture, frames: Sequence[int]) -> list[Camera]:
    """Cameras at the size that their images have, one image of each camera being opened."""
    true: dict[Camera, Camera] = {}
    for i in frames:
        camera = raw.cameras[i]
        if camera not in true:
            height, width = images.load(raw.images[i]).shape[:2]
            scaled = camera.colmap
            scaled.rescale(width, height)
            true[camera] = Camera(camera.model, width, height, tuple(scaled.params))
    return [true[raw.cameras[i]] for i in frames]


def _model(
    raw: RawCapture, names: Sequence[str], cameras: Sequence[Camera]
) -> pycolmap.Reconstruction:
    """All of a raw capture's frames, and the points that two or more of them see.

    Args:
        raw: the frames.
        names: of their images.
        cameras: at the size of their images.
    """
    model = pycolmap.Reconstruction()
    numbers = {camera: n for n, camera in enumerate(dict.fromkeys(cameras), 1)}
    for camera, number in numbers.items():
        numbered = camera.colmap
        numbered.camera_id = number
        model.add_camera_with_trivial_rig(numbered)
    points = raw.sparse() or NO_POINTS
    shared = _shared(points, len(names))
    tracks: dict[int, pycolmap.Track] = {}
    for i, (name, camera, pose) in enumerate(zip(names, cameras, raw.world_to_camera, strict=True)):
        stated = np.array([raw.cameras[i].width, raw.cameras[i].height])
        rows = shared[i]
        image = pycolmap.Image(
            image_id=i + 1,
            name=name,
            camera_id=numbers[camera],
            keypoints=points.track_xy[rows] * ([camera.width, camera.height] / stated),
        )
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        model.add_image_with_trivial_frame(image, rigid)
        for at, row in enumerate(rows):
            point = int(points.track_point[row])
            tracks.setdefault(point, pycolmap.Track()).add_element(i + 1, at)
    for point in sorted(tracks):
        model.add_point3D(points.xyz[point], tracks[point], points.rgb[point])
    return model


def _shared(points: RawPoints, frames: int) -> list[np.ndarray]:
    """For each frame the rows of the tracks of points that enough frames see."""
    seen = np.bincount(points.track_point, minlength=len(points.xyz))
    enough = seen[points.track_point] >= LEAST_TRACK
    return [np.flatnonzero(enough & (points.track_frame == i)) for i in range(frames)]


def _transforms(
    opened: Opened,
    train: Sequence[int],
    held: Sequence[int],
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
    shared = intrinsics[train[0]]
    if any(values != shared for values in intrinsics.values()):
        frames = [frame | intrinsics[i] for frame, i in zip(frames, sorted(names), strict=True)]
        shared = {"camera_model": shared["camera_model"]}
    tested = held or train
    return {
        **shared,
        "train_filenames": [paths[i] for i in train],
        "val_filenames": [paths[i] for i in tested],
        "test_filenames": [paths[i] for i in tested],
        "frames": frames,
    }


def _intrinsics(camera: Camera) -> dict:
    simple = camera.model in SIMPLE
    params = (camera.params[0], *camera.params) if simple else camera.params
    keys = ("fl_x", "fl_y", "cx", "cy", *DISTORTION[camera.model])
    return {
        "camera_model": "OPENCV_FISHEYE" if "FISHEYE" in camera.model else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        **dict(zip(keys, params, strict=True)),
    }
