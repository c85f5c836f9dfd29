"""COLMAP models, binary or text, through pycolmap."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.captures.colmap import model as colmap_model
from fsel.captures.colmap.camera import Camera, pycolmap
from fsel.captures.colmap.model import check_whole, is_binary, observed, points_of
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import Layout, RawCapture, Recording
from fsel.captures.parsing import check_turn, inside, read_text, slashed
from fsel.core.names import matched
from fsel.core.points import RawPoints, grouped_rows

MODEL_FOLDERS = ("sparse/0", "sparse", "colmap/sparse/0", "colmap", "dense/sparse", ".")
IMAGE_FOLDERS = ("images", "images_2", "images_4", "images_8", "input")


def find_model(folder: Path) -> Path | None:
    """Return the folder of the COLMAP model inside a capture, or None."""
    for candidate in MODEL_FOLDERS:
        model = folder / candidate
        if any((model / f"images.{ending}").is_file() for ending in ("bin", "txt")):
            return model
    return None


def find_images(folder: Path) -> Path:
    """Return the folder that holds the images."""
    for candidate in IMAGE_FOLDERS:
        if (folder / candidate).is_dir():
            return folder / candidate
    allowed = ", ".join(IMAGE_FOLDERS)
    raise FileNotFoundError(f"{folder}: no image folder; looked for {allowed}")


def load_model(model: Path) -> pycolmap.Reconstruction:
    """Read a model, binary or text, with or without rigs.

    Raises:
        ValueError: when it cannot be read, is empty, or its text lacks a line.
    """
    check_whole(model)
    try:
        reconstruction = pycolmap.Reconstruction(str(model))
        for image in reconstruction.images.values():
            image.name = slashed(image.name)  # UnicodeDecodeError for one that is no text
    except (ValueError, RuntimeError, IndexError, MemoryError) as error:
        raise ValueError(f"{model}: not a readable COLMAP model ({error})") from error
    if not reconstruction.images:
        raise ValueError(f"{model}: the COLMAP model holds no images")
    _check_turns(reconstruction, model)
    for key, camera in reconstruction.cameras.items():  # observations are scaled by its size
        if not (camera.width and camera.height):
            size = f"{camera.width}x{camera.height}"
            raise ValueError(f"{model}: camera {key} has {size} pixels; at least 1x1 are allowed")
    if not is_binary(model):
        _complete_names(reconstruction, model / "images.txt")
    return reconstruction


def _check_turns(reconstruction: pycolmap.Reconstruction, model: Path) -> None:
    """Refuse quaternions that are no turn, of frames and of sensors in rigs."""
    poses = {
        f"frame {key}": frame.rig_from_world
        for key, frame in reconstruction.frames.items()
        if frame.has_pose
    }
    for rig in reconstruction.rigs.values():
        for sensor, pose in rig.non_ref_sensors.items():
            if pose is not None:
                poses[f"sensor {sensor.id} of rig {rig.rig_id}"] = pose
    for what, pose in poses.items():
        check_turn(pose.rotation.quat, model, what)


def _complete_names(reconstruction: pycolmap.Reconstruction, path: Path) -> None:
    """Give images of a text model their full names, which pycolmap cuts at the first space.

    A missing line of 2D points, which must be there though empty, shifts all that follow: refused.
    """
    text = read_text(path)
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    while lines and not lines[-1].strip():
        lines.pop()
    for at in range(0, len(lines), 2):
        fields = lines[at].split(maxsplit=9)
        points = lines[at + 1].split() if at + 1 < len(lines) else []
        if len(fields) < 10 or len(points) % 3:
            raise ValueError(
                f"{path}: image {at // 2 + 1} is not a line of ten fields followed by a line of "
                "2D points in threes; a line of points must be there though it be empty"
            )
        reconstruction.images[int(fields[0])].name = slashed(fields[9])


def read(folder: Path) -> RawCapture:
    """Read a capture with `sparse/0` (or a sibling) and `images`; masks from `masks`."""
    model = find_model(folder)
    if model is None:
        allowed = ", ".join(MODEL_FOLDERS)
        raise FileNotFoundError(f"{folder}: no COLMAP model; looked in {allowed}")
    images = find_images(folder)
    raw = from_model(load_model(model), images, model)
    if not (folder / "masks").is_dir():
        return raw
    return replace(raw, masks=[_mask(folder / "masks", name) for name in raw.names])


def _mask(folder: Path, name: str) -> Path:
    """COLMAP appends .png to the image's name; others replace the ending."""
    appended = folder / f"{name}.png"
    return appended if appended.is_file() else (folder / name).with_suffix(".png")


def from_model(reconstruction: pycolmap.Reconstruction, images: Path, model: Path) -> RawCapture:
    """Return a raw capture of a loaded model whose image names lie below `images`."""
    posed = sorted(
        (image for image in reconstruction.images.values() if image.has_pose),
        key=lambda image: image.name,
    )
    names = [image.name for image in posed]
    ids = [image.image_id for image in posed]
    seen = cache(lambda: observed(reconstruction, model))
    return RawCapture(
        names=names,
        images=_image_files(images, names, model),
        world_to_camera=np.array([i.cam_from_world().matrix() for i in posed]),
        cameras=[camera_of(reconstruction.cameras[image.camera_id]) for image in posed],
        sequences=[str(PurePosixPath(name).parent) for name in names],
        points=cache(
            lambda rows: points_of(seen(), {ids[row]: at for at, row in enumerate(rows)}, model)
        ),
        dropped={i.name: "no pose" for i in reconstruction.images.values() if not i.has_pose},
    )


def _image_files(images: Path, names: list[str], model: Path) -> list[Path]:
    """Files by name; where downscaled copies have another ending, the one of the same folder.

    Missing files are left to validation, which refuses them or leaves their frames out.
    """
    files = [inside(images, name, model) for name in names]
    there = {folder: _by_stem(folder) for folder in {file.parent for file in files}}
    chosen = []
    for file in files:
        alike = there[file.parent].get(file.stem, [])
        other = len(alike) == 1 and file.name not in alike
        chosen.append(file.with_name(alike[0]) if other else file)
    twice = [file for file, count in Counter(chosen).items() if count > 1]
    if twice:
        raise ValueError(f"{twice[0]}: would stand for several images of {model}")
    return chosen


def _by_stem(folder: Path) -> dict[str, list[str]]:
    """Return the names of a folder's files by what comes before their endings."""
    names: dict[str, list[str]] = {}
    for name in os.listdir(folder) if folder.is_dir() else ():
        if os.path.isfile(os.path.join(folder, name)):
            names.setdefault(Path(name).stem, []).append(name)
    return names


def camera_of(camera: pycolmap.Camera) -> Camera:
    """Return pycolmap's camera as ours."""
    return Camera(camera.model_name, camera.width, camera.height, tuple(camera.params))


def with_points(raw: RawCapture, model: Path) -> RawCapture:
    """Add the points of a COLMAP model to a capture of the same world, images matched by name."""
    return replace(raw, points=cache(lambda rows: _points_beside(raw, model, rows)))


def _points_beside(raw: RawCapture, model: Path, frames: tuple[int, ...]) -> RawPoints | None:
    """Return points of a model; observations of cameras of another size are brought to `raw`'s."""
    reconstruction = load_model(model)
    rows = matched(raw.names, [image.name for image in reconstruction.images.values()])
    position = {row: at for at, row in enumerate(frames)}
    images = [i for i in reconstruction.images.values() if rows.get(i.name) in position]
    numbered = {image.image_id: position[rows[image.name]] for image in images}
    points = points_of(observed(reconstruction, model), numbered, model)
    if points is None:
        return None
    scale = np.ones((len(frames), 2))
    for image in images:
        stated, own = raw.cameras[rows[image.name]], reconstruction.cameras[image.camera_id]
        scale[numbered[image.image_id]] = [stated.width / own.width, stated.height / own.height]
    return replace(points, track_xy=points.track_xy * scale[points.track_frame])


def build_model(recording: Recording, camera: Camera, names: list[str], keep: np.ndarray):
    """Return a pycolmap model of a recording's kept frames, its observations scaled to `camera`."""
    scale = camera.width / recording.camera.width
    kept = np.flatnonzero(keep).tolist()
    seen = grouped_rows(recording.track_frame, len(names))
    rows = [seen[i] for i in kept]
    return colmap_model.build_model(
        [names[i] for i in kept],
        [camera.colmap] * len(kept),
        recording.world_to_camera[kept],
        recording.xyz,
        recording.rgb,
        [recording.track_point[row] for row in rows],
        [recording.track_xy[row] * scale for row in rows],
        ids=[i + 1 for i in kept],
        least=2,
    )


def scaled(camera: Camera, factor: int) -> Camera:
    """The same camera as if its images were `factor` times larger; distortion is unitless."""
    lengths = {"PINHOLE": 4, "OPENCV": 4, "OPENCV_FISHEYE": 4}[camera.model]
    params = tuple(p * factor if i < lengths else p for i, p in enumerate(camera.params))
    return Camera(camera.model, camera.width * factor, camera.height * factor, params)


def write_text(model: pycolmap.Reconstruction, folder: Path) -> None:
    """Write a model's text files into a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    model.write_text(str(folder))


def write(recording: Recording, folder: Path) -> None:
    """Write images/ and the text model sparse/0, without frames whose pose was lost."""
    names = [f"{name}.png" for name in recording.names]
    image_files.write(recording.images, folder / "images", names)
    model = build_model(recording, recording.camera, names, ~recording.lost)
    write_text(model, folder / "sparse" / "0")


LAYOUT = Layout("colmap", lambda folder: find_model(folder) is not None, read, write)
