"""Layout of nerfstudio: transforms.json."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.captures.colmap.camera import Camera, brown
from fsel.captures.layouts import colmap, ply_points
from fsel.captures.layouts.contract import Layout, RawCapture, Recording, has_file
from fsel.captures.parsing import (
    inside,
    member,
    number,
    numbers,
    read_json,
    slashed,
    text,
    world_transform,
)
from fsel.core.geometry import OPENGL_TO_OPENCV, from_opengl, invert_pose
from fsel.core.points import RawPoints

OLD_APPLIED_TRANSFORM = np.array([[0.0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]])
"""World rotation of nerfstudio's COLMAP import before January 2024."""
NEW_APPLIED_TRANSFORM = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]])
"""And since."""
FOLDERS = ("images_2", "images_4", "images_8")
SPLITS = ("train_filenames", "val_filenames", "test_filenames")
DISTORTION = ("k1", "k2", "p1", "p2")
FISHEYE = ("k1", "k2", "k3", "k4")
LISTED = ("k1", "k2", "k3", "k4", "p1", "p2")  # order of distortion_params
PERSPECTIVE = ("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV")
SIMPLE = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")
STRAIGHT = ("SIMPLE_PINHOLE", "PINHOLE")  # cameras without distortion
COEFFICIENTS = {
    **dict.fromkeys(STRAIGHT, ()),
    **dict.fromkeys(("SIMPLE_RADIAL", "SIMPLE_RADIAL_FISHEYE"), ("k1",)),
    **dict.fromkeys(("RADIAL", "RADIAL_FISHEYE"), ("k1", "k2")),
    "OPENCV": DISTORTION,
    "OPENCV_FISHEYE": FISHEYE,
}
"""Camera models that nerfstudio has too, and its names of their coefficients."""
NUMBERS = ("w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x", *LISTED)


def read(folder: Path) -> RawCapture:
    """Read transforms.json, and points from a model beside it or its `ply_file_path`; beside
    colmap/sparse/0 a file without `applied_transform` carries the old one, as in nerfstudio."""
    own = folder / "colmap" / "sparse" / "0"
    undo = OLD_APPLIED_TRANSFORM if own.is_dir() else None
    raw = from_json(folder / "transforms.json", folder, undo=undo)
    model = own if own.is_dir() else folder / "sparse" / "0"
    return colmap.with_points(raw, model) if model.is_dir() else raw


def from_json(
    path: Path,
    folder: Path,
    *,
    content: dict | None = None,
    images: str = "",
    masks: str = "",
    undo: np.ndarray | None = None,
    copies: tuple[str, ...] = (),
) -> RawCapture:
    """Read the frames of a transforms.json, in the world before `applied_transform`.

    Frames marked bad, and frames that no `*_filenames` list names, are left out.

    Args:
        folder: the capture; image paths must stay inside it.
        images, masks: folders of the capture that names of images and of masks are relative to.
        undo: (3, 4) world transform that the poses carry though the file does not say so.
        copies: folders beside the images' own whose smaller copies are taken instead of them.
    """
    content = read_json(path) if content is None else content
    frames, dropped = _frames(content, path)
    stored = content.get("applied_transform")
    applied = undo if stored is None else world_transform(stored, path, "applied_transform")
    scale = number(content.get("applied_scale", 1.0), path, "applied_scale")
    names = [frame["file_path"].removeprefix("./").removeprefix("images/") for frame in frames]
    masked = [f for f in frames if f.get("mask_path")] if content.get("has_mask", True) else []
    if masked and len(masked) != len(frames):
        raise ValueError(f"{path}: {len(masked)} of {len(frames)} frames have a mask_path, not all")
    mask_names = [slashed(text(frame, "mask_path", path)) for frame in masked]
    files = [inside(folder, Path(images, frame["file_path"]), path) for frame in frames]

    @cache
    def cloud() -> RawPoints:
        file = inside(folder, slashed(text(content, "ply_file_path", path)), path)
        return ply_points.read(file, applied, scale)

    return RawCapture(
        names=names,
        images=[_existing(file, copies) for file in files],
        world_to_camera=np.array([_pose(frame, applied, scale, path) for frame in frames]),
        cameras=[camera_of(content, frame, path) for frame in frames],
        sequences=[str(PurePosixPath(name).parent) for name in names],
        masks=[_existing(inside(folder, Path(masks, name), path)) for name in mask_names] or None,
        points=(lambda frames: cloud()) if content.get("ply_file_path") is not None else None,
        dropped=dropped,
    )


def _frames(content: dict, path: Path) -> tuple[list[dict], dict[str, str]]:
    """Return the frames to use, and those left out with the reason."""
    frames = content.get("frames")
    if not isinstance(frames, list) or not frames:
        raise ValueError(f"{path}: 'frames' must be a list of frames")
    frames = [
        frame | {"file_path": slashed(text(frame, "file_path", path, f"frames[{at}]"))}
        for at, frame in enumerate(frames)
    ]
    dropped = {f["file_path"]: "marked bad by its owner" for f in frames if f.get("is_bad")}
    if any(key in content for key in SPLITS):
        lists = {key: content.get(key, []) for key in SPLITS}
        for key, listed in lists.items():
            if not isinstance(listed, list) or not all(isinstance(name, str) for name in listed):
                raise ValueError(f"{path}: {key} must be a list of names, got {repr(listed)[:80]}")
        named = {slashed(name) for listed in lists.values() for name in listed}
        absent = sorted(named - {frame["file_path"] for frame in frames})
        if absent:
            raise ValueError(f"{path}: {absent[0]!r} is in a *_filenames list but not in 'frames'")
        reason = "in none of the *_filenames lists"
        dropped |= {f["file_path"]: reason for f in frames if f["file_path"] not in named}
    kept = [frame for frame in frames if frame["file_path"] not in dropped]
    if not kept:
        raise ValueError(f"{path}: every frame is marked bad or in no *_filenames list")
    return kept, dropped


def _existing(file: Path, copies: tuple[str, ...] = ()) -> Path:
    """The image, or its downscaled copy where that is wanted or only that was distributed."""
    if not file.suffix:  # as Blender's exporters name images, and apps on phones
        named = [file.with_suffix(ending) for ending in (".png", ".jpg")]
        file = next((path for path in named if path.is_file()), named[0])
    folders = [file.parents[1] / name for name in copies]
    folders += [file.parent, *(file.parents[1] / name for name in FOLDERS)]
    return next((path for folder in folders if (path := folder / file.name).is_file()), file)


def _pose(frame: dict, applied: np.ndarray | None, scale: float, path: Path) -> np.ndarray:
    stored = member(frame, "transform_matrix", path, frame["file_path"])
    shape = (len(stored), 4) if isinstance(stored, list) and len(stored) == 3 else (4, 4)
    matrix = numbers(stored, shape, path, f"transform_matrix of {frame['file_path']}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{path}: transform_matrix of {frame['file_path']} is not finite")
    matrix = np.vstack([matrix[:3], [0, 0, 0, 1]])
    matrix[:3, 3] /= scale
    if applied is not None:
        matrix = np.linalg.inv(np.vstack([applied, [0, 0, 0, 1]])) @ matrix
    return from_opengl(matrix)


def camera_of(content: dict, frame: dict, path: Path) -> Camera:
    """Return the camera of a frame; a top-level value wins over the frame's, as in nerfstudio."""
    merged = {key: value for key, value in {**frame, **content}.items() if value is not None}
    merged |= {
        key: number(merged[key], path, f"{key} of {frame['file_path']}")
        for key in NUMBERS
        if key in merged
    }
    width, height, focal = (merged.get(key) for key in ("w", "h", "fl_x"))
    angle = merged.get("camera_angle_x", 0)
    if focal is None and width and 0 < angle < np.pi:
        focal = 0.5 * width / np.tan(angle / 2)
    if not (width and height and focal):
        raise ValueError(
            f"{path}: intrinsics of {frame['file_path']} are missing; need w, h and fl_x "
            "(or camera_angle_x, between 0 and pi), at the top level or in the frame"
        )
    cx, cy = merged.get("cx", width / 2), merged.get("cy", height / 2)
    pinhole = (float(focal), float(merged.get("fl_y", focal)), float(cx), float(cy))
    return _with_distortion(merged, pinhole, (int(width), int(height)), path)


def _with_distortion(
    merged: dict, pinhole: tuple[float, ...], size: tuple[int, int], path: Path
) -> Camera:
    stated = merged.get("distortion_params") or []
    if not isinstance(stated, list) or len(stated) > len(LISTED):
        names = ", ".join(LISTED)
        raise ValueError(f"{path}: distortion_params must be a list of {names}, got {stated!r:.80}")
    listed = {
        key: number(entry, path, f"distortion_params ({key})")
        for key, entry in zip(LISTED, stated, strict=False)
    }
    value = {key: float(merged.get(key, listed.get(key, 0.0))) for key in LISTED}
    model = merged.get("camera_model", "OPENCV")
    if model == "OPENCV_FISHEYE":
        return Camera(model, *size, (*pinhole, *(value[key] for key in FISHEYE)))
    if model not in PERSPECTIVE:
        allowed = ", ".join((*PERSPECTIVE, "OPENCV_FISHEYE"))
        raise ValueError(f"{path}: camera_model is {model!r}; allowed: {allowed}")
    if value["k4"]:
        raise ValueError(f"{path}: k4 is {value['k4']}; only a fisheye camera has it")
    return brown(size, pinhole, *(value[key] for key in (*DISTORTION, "k3")))


def intrinsics_of(camera: Camera) -> dict:
    """Return the intrinsic keys of a camera of a model in `COEFFICIENTS`."""
    simple = camera.model in SIMPLE
    params = (camera.params[0], *camera.params) if simple else camera.params
    keys = ("fl_x", "fl_y", "cx", "cy", *COEFFICIENTS[camera.model])
    return {
        "camera_model": "OPENCV_FISHEYE" if "FISHEYE" in camera.model else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        **dict(zip(keys, params, strict=True)),
    }


def matrix_of(world_to_camera: np.ndarray, applied: np.ndarray) -> list:
    """Return a transform_matrix: camera to world, OpenGL axes, in the transformed world."""
    matrix = np.eye(4)
    matrix[:3] = invert_pose(world_to_camera)
    matrix[:3, :3] = matrix[:3, :3] @ OPENGL_TO_OPENCV
    return (np.vstack([applied, [0, 0, 0, 1]]) @ matrix).tolist()


def frames_of(names: Sequence[str], world_to_camera: np.ndarray, applied: np.ndarray) -> list[dict]:
    """Return the frames of a transforms.json, whose poses carry a (3, 4) world transform."""
    return [
        {"file_path": name, "transform_matrix": matrix_of(pose, applied)}
        for name, pose in zip(names, world_to_camera, strict=True)
    ]


def write_scene(
    recording: Recording, camera: Camera, names: list[str], applied: np.ndarray, folder: Path
) -> None:
    """Write transforms.json for files under images/; frames in arbitrary order, as of COLMAP."""
    paths = [f"images/{name}" for name in names]
    frames = frames_of(paths, recording.world_to_camera, applied)
    stated = {"applied_transform": applied.tolist(), "frames": frames[::2] + frames[1::2]}
    content = json.dumps(intrinsics_of(camera) | stated)
    (folder / "transforms.json").write_text(content)


def write(recording: Recording, folder: Path) -> None:
    """Write images/ and transforms.json."""
    names = recording.write_images(folder / "images", "png")
    write_scene(recording, recording.camera, names, NEW_APPLIED_TRANSFORM, folder)


LAYOUT = Layout("nerfstudio", has_file("transforms.json"), read, write)
