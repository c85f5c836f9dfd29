"""CO3D v2: gzipped annotations for a category, cameras in PyTorch3D's NDC conventions."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import Layout, RawCapture, Recording
from fsel.captures.parsing import inside, member, number, numbers, read_json_list, text

FRAMES = "frame_annotations.jgz"
SEQUENCES = "sequence_annotations.jgz"
AXES = np.array([-1.0, -1.0, 1.0])  # PyTorch3D: x left, y up
FOREGROUND = 128  # of a mask, which is the probability of the object times 255
ISOTROPIC, PER_AXIS = "ndc_isotropic", "ndc_norm_image_bounds"


def recognises(folder: Path) -> bool:
    """Look for a category's annotations beside a sequence, or in a dataset of one sequence."""
    return _annotations(folder) is not None


def _annotations(folder: Path) -> Path | None:
    places = [folder.parent / FRAMES, *sorted(folder.glob(f"*/{FRAMES}"))]
    return next((path for path in places if path.is_file()), None)


def read(folder: Path, min_quality: float = 0.5) -> RawCapture:
    """Read a sequence, <category>/<sequence> or a dataset of one, in order of `frame_number`; its
    viewpoints have at least `min_quality`, and the object's masks count."""
    path = _annotations(folder)
    if path is None:
        raise FileNotFoundError(f"{folder}: no {FRAMES} in the category's folder, {folder.parent}")
    root, frames = path.parent.parent, read_json_list(path)
    names = {str(member(frame, "sequence_name", path)) for frame in frames}
    inner = path.parent != folder.parent  # a dataset's folder, not that of a sequence
    name = next(iter(names), "") if inner else folder.name
    if name not in names or (inner and len(names) > 1):
        raise ValueError(
            f"{path}: {len(names)} sequences, and {name!r} is not the only or wanted one"
        )
    _check_quality(path.with_name(SEQUENCES), name, min_quality)
    own = sorted(
        (frame for frame in frames if frame["sequence_name"] == name),
        key=lambda frame: number(frame.get("frame_number"), path, "frame_number"),
    )
    kept, dropped = [], {}
    for frame in own:
        file = text(member(frame, "image", path), "path", path, "image")
        if not frame.get("viewpoint"):
            dropped[file] = "no viewpoint"
        elif not inside(root, file, path).is_file():
            dropped[file] = "image hidden or not downloaded"
        else:
            kept.append(frame)
    if not kept:
        raise ValueError(f"{path}: no frame of {name} has an image and a viewpoint")
    return _capture(kept, root, path, dropped)


def _capture(frames: list[dict], root: Path, path: Path, dropped: dict[str, str]) -> RawCapture:
    masked = [frame["mask"] for frame in frames if frame.get("mask")]
    masks = [inside(root, text(mask, "path", path, "mask"), path) for mask in masked]
    return RawCapture(
        names=[f"{int(frame['frame_number']):06d}" for frame in frames],
        images=[inside(root, frame["image"]["path"], path) for frame in frames],
        world_to_camera=np.array([_pose(frame, path) for frame in frames]),
        cameras=[_camera(frame, path) for frame in frames],
        sequences=[frames[0]["sequence_name"]] * len(frames),
        masks=masks if len(masks) == len(frames) else None,
        mask_values=(FOREGROUND, 255),
        dropped=dropped,
    )


def _check_quality(path: Path, name: str, least: float) -> None:
    if not path.is_file():
        raise FileNotFoundError(f"{path}: missing; it says how good the poses are")
    sequence = next((s for s in read_json_list(path) if s.get("sequence_name") == name), {})
    quality = sequence.get("viewpoint_quality_score")
    if quality is None or number(quality, path, "viewpoint_quality_score") < least:
        raise ValueError(
            f"{path}: viewpoint_quality_score of {name} is {quality}, below the required "
            f"{least:g}. Hint: choose another sequence, or lower `reading.min_quality`"
        )


def _pose(frame: dict, path: Path) -> np.ndarray:
    """Return the world-to-camera with OpenCV axes of Xc = Xw R + T with x to the left and y up."""
    viewpoint = frame["viewpoint"]
    rotation = (numbers(member(viewpoint, "R", path), (3, 3), path, "viewpoint.R") * AXES).T
    translation = numbers(member(viewpoint, "T", path), (3,), path, "viewpoint.T") * AXES
    return np.column_stack([rotation, translation])


def _camera(frame: dict, path: Path) -> Camera:
    """Return the pixels from NDC; the annotation's size is (height, width)."""
    size = numbers(frame["image"].get("size"), (2,), path, "image.size")
    height, width = (int(number(length, path, "image.size")) for length in size)
    viewpoint = frame["viewpoint"]
    kind = viewpoint.get("intrinsics_format", PER_AXIS)
    if kind not in (ISOTROPIC, PER_AXIS):
        raise ValueError(f"{path}: intrinsics_format is {kind!r}; allowed: {ISOTROPIC}, {PER_AXIS}")
    half = np.array([width, height]) / 2
    scale = np.full(2, half.min()) if kind == ISOTROPIC else half
    focal = numbers(viewpoint.get("focal_length"), (2,), path, "viewpoint.focal_length") * scale
    point = numbers(viewpoint.get("principal_point"), (2,), path, "viewpoint.principal_point")
    center = half - point * scale
    return Camera("PINHOLE", width, height, (*focal.tolist(), *center.tolist()))


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as a dataset of one sequence; frames whose pose was lost lack one."""
    category, sequence = "object", "1_1_1"
    home = f"{category}/{sequence}"
    names = recording.write_images(folder / home / "images", "jpg")
    masks = recording.write_masks(folder / home / "masks")
    frames = []
    for at, name in enumerate(names):
        size = [recording.camera.height, recording.camera.width]
        frame = {
            "sequence_name": sequence,
            "frame_number": at,
            "image": {"path": f"{home}/images/{name}", "size": size},
            "viewpoint": None if recording.lost[at] else _viewpoint(recording, at),
        }
        if masks:
            frame["mask"] = {"path": f"{home}/masks/{masks[at]}"}
        frames.append(frame)
    quality = {"sequence_name": sequence, "category": category, "viewpoint_quality_score": 1.0}
    for name, content in ((FRAMES, frames[::2] + frames[1::2]), (SEQUENCES, [quality])):
        packed = gzip.compress(json.dumps(content).encode(), mtime=0)
        (folder / category / name).write_bytes(packed)


def _viewpoint(recording: Recording, at: int) -> dict:
    camera, pose = recording.camera, recording.world_to_camera[at]
    fx, fy, cx, cy = camera.params
    scale = min(camera.width, camera.height) / 2
    center = [(camera.width / 2 - cx) / scale, (camera.height / 2 - cy) / scale]
    return {
        "R": (pose[:, :3].T * AXES).tolist(),
        "T": (pose[:, 3] * AXES).tolist(),
        "focal_length": [fx / scale, fy / scale],
        "principal_point": center,
        "intrinsics_format": ISOTROPIC,
    }


LAYOUT = Layout("co3d", recognises, read, write, ("min_quality",))
