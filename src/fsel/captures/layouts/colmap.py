"""COLMAP models, binary or text, through pycolmap."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.captures.colmap import model as colmap_model
from fsel.captures.colmap.camera import Camera, pycolmap
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


def load_model(model: Path) -> pycolmap.Reconstruction:
    """Read a model, binary or text, with or without rigs; what is wrong with it is refused."""
    colmap_model.check_whole(model)
    try:
        reconstruction = pycolmap.Reconstruction(str(model))
        for image in reconstruction.images.values():
            image.name = slashed(image.name)  # UnicodeDecodeError for one that is no text
    except (ValueError, RuntimeError, IndexError, MemoryError) as error:
        raise ValueError(f"{model}: not a readable COLMAP model ({error})") from error
    if not reconstruction.images:
        raise ValueError(f"{model}: the COLMAP model contains no images")
    for key, frame in reconstruction.frames.items():
        if frame.has_pose:
            check_turn(frame.rig_from_world.rotation.quat, model, f"frame {key}")
    for rig in reconstruction.rigs.values():
        for sensor, pose in rig.non_ref_sensors.items():
            if pose is not None:
                what = f"sensor {sensor.id} of rig {rig.rig_id}"
                check_turn(pose.rotation.quat, model, what)
    for key, camera in reconstruction.cameras.items():  # observations are scaled by its size
        if not (camera.width and camera.height):
            size = f"{camera.width}x{camera.height}"
            raise ValueError(f"{model}: camera {key} has {size} pixels; at least 1x1 are allowed")
    if not colmap_model.is_binary(model):
        _complete_names(reconstruction, model / "images.txt")
    return reconstruction


def _complete_names(reconstruction: pycolmap.Reconstruction, path: Path) -> None:
    """Restore names that pycolmap cuts at a space; refuse a model without lines of 2D points."""
    lines = [line for line in read_text(path).splitlines() if not line.startswith("#")]
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
    images = next((folder / name for name in IMAGE_FOLDERS if (folder / name).is_dir()), None)
    if images is None:
        allowed = ", ".join(IMAGE_FOLDERS)
        raise FileNotFoundError(f"{folder}: no image folder; looked for {allowed}")
    raw, masks = from_model(load_model(model), images, model), folder / "masks"
    if not masks.is_dir():
        return raw
    # COLMAP appends .png to the image's name; others replace the ending
    files = [(masks / f"{name}.png", (masks / name).with_suffix(".png")) for name in raw.names]
    return replace(raw, masks=[one if one.is_file() else other for one, other in files])


def from_model(reconstruction: pycolmap.Reconstruction, images: Path, model: Path) -> RawCapture:
    """Return a raw capture of a loaded model whose image names lie below `images`."""
    posed = sorted(
        (image for image in reconstruction.images.values() if image.has_pose),
        key=lambda image: image.name,
    )
    names = [image.name for image in posed]
    return RawCapture(
        names=names,
        images=_image_files(images, names, model),
        world_to_camera=np.array([i.cam_from_world().matrix() for i in posed]),
        cameras=[camera_of(reconstruction.cameras[image.camera_id]) for image in posed],
        sequences=[str(PurePosixPath(name).parent) for name in names],
        points=colmap_model.points_reader(
            reconstruction, [image.image_id for image in posed], model
        ),
        dropped={i.name: "no pose" for i in reconstruction.images.values() if not i.has_pose},
    )


def _image_files(images: Path, names: list[str], model: Path) -> list[Path]:
    """Return files by name, missing ones too, or the one copy with the same stem in the folder."""
    files = [inside(images, name, model) for name in names]
    there: dict[tuple[Path, str], list[Path]] = {}
    for folder in {file.parent for file in files if file.parent.is_dir()}:
        for file in folder.iterdir():
            if file.is_file():
                there.setdefault((folder, file.stem), []).append(file)
    alike = [there.get((file.parent, file.stem), []) for file in files]
    chosen = [one[0] if len(one) == 1 else file for file, one in zip(files, alike, strict=True)]
    twice = [file for file, count in Counter(chosen).items() if count > 1]
    if twice:
        raise ValueError(f"{twice[0]}: would match several images of {model}")
    return chosen


def camera_of(camera: pycolmap.Camera) -> Camera:
    """Return pycolmap's camera as ours."""
    return Camera(camera.model_name, camera.width, camera.height, tuple(camera.params))


def with_points(raw: RawCapture, model: Path) -> RawCapture:
    """Add the points of a COLMAP model to a capture of the same world, images matched by name."""

    @cache
    def points(frames: tuple[int, ...]) -> RawPoints | None:
        reconstruction = load_model(model)
        rows = matched(raw.names, [image.name for image in reconstruction.images.values()])
        position = {row: at for at, row in enumerate(frames)}
        images = [i for i in reconstruction.images.values() if rows.get(i.name) in position]
        numbered = {image.image_id: position[rows[image.name]] for image in images}
        found = colmap_model.points_of(
            colmap_model.observed(reconstruction, model), numbered, model
        )
        if found is None:
            return None
        scale = np.ones((len(frames), 2))  # the model's cameras may be of another size
        for image in images:
            stated, own = raw.cameras[rows[image.name]], reconstruction.cameras[image.camera_id]
            scale[numbered[image.image_id]] = [stated.width / own.width, stated.height / own.height]
        return replace(found, track_xy=found.track_xy * scale[found.track_frame])

    return replace(raw, points=points)


def write_sparse(
    recording: Recording,
    camera: Camera,
    names: list[str],
    folder: Path,
    *,
    lost: bool = True,
    text: bool = False,
) -> None:
    """Write a COLMAP model at a camera's size; with `lost`, with frames whose pose was lost."""
    scale = camera.width / recording.camera.width
    kept = np.flatnonzero(~recording.lost | lost).tolist()
    seen = grouped_rows(recording.track_frame, len(names))
    rows = [seen[i] for i in kept]
    model = colmap_model.build_model(
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
    colmap_model.write_model(model, folder, text=text)


def scaled(camera: Camera, factor: int) -> Camera:
    """Return a PINHOLE, OPENCV or OPENCV_FISHEYE camera whose images are so many times larger."""
    params = (*(length * factor for length in camera.params[:4]), *camera.params[4:])
    return Camera(camera.model, camera.width * factor, camera.height * factor, params)


def write(recording: Recording, folder: Path) -> None:
    """Write images/ and the text model sparse/0, without frames whose pose was lost."""
    names = recording.write_images(folder / "images", "png")
    write_sparse(recording, recording.camera, names, folder / "sparse/0", lost=False, text=True)


LAYOUT = Layout("colmap", lambda folder: find_model(folder) is not None, read, write)
