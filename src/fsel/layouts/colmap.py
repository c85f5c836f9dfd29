"""COLMAP models, binary or text, through pycolmap."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pycolmap

from fsel.layouts.base import Layout, RawCapture, RawPoints
from fsel.recording import Camera, Recording

MODEL_FOLDERS = ("sparse/0", "sparse", "colmap/sparse/0", "colmap", "dense/sparse", ".")
IMAGE_FOLDERS = ("images", "images_2", "images_4", "images_8", "input")


def find_model(folder: Path) -> Path | None:
    """The folder of the COLMAP model inside a capture, or None."""
    for candidate in MODEL_FOLDERS:
        model = folder / candidate
        if any((model / f"images.{ending}").is_file() for ending in ("bin", "txt")):
            return model
    return None


def find_images(folder: Path) -> Path:
    """The folder that holds the images."""
    for candidate in IMAGE_FOLDERS:
        if (folder / candidate).is_dir():
            return folder / candidate
    allowed = ", ".join(IMAGE_FOLDERS)
    raise FileNotFoundError(f"{folder}: no image folder; looked for {allowed}")


def load_model(model: Path) -> pycolmap.Reconstruction:
    """Read a model, refusing an empty one."""
    try:
        reconstruction = pycolmap.Reconstruction(str(model))
    except (ValueError, RuntimeError) as error:
        raise ValueError(f"{model}: not a readable COLMAP model ({error})") from error
    if not reconstruction.images:
        raise ValueError(f"{model}: the COLMAP model holds no images")
    return reconstruction


def read(folder: Path) -> RawCapture:
    """A capture with `sparse/0` (or a sibling) and `images`."""
    model = find_model(folder)
    if model is None:
        allowed = ", ".join(MODEL_FOLDERS)
        raise FileNotFoundError(f"{folder}: no COLMAP model; looked in {allowed}")
    return from_model(load_model(model), find_images(folder), model)


def from_model(
    reconstruction: pycolmap.Reconstruction, images: Path, model: Path, strip: str = ""
) -> RawCapture:
    """A raw capture of a loaded model whose image names lie below `images`."""
    posed = [image for image in reconstruction.images.values() if image.has_pose]
    posed.sort(key=lambda image: image.name)
    names = [image.name.removeprefix(strip) for image in posed]
    files = _image_files(images, names, model)
    return RawCapture(
        names=names,
        images=files,
        world_to_camera=np.array([i.cam_from_world().matrix() for i in posed]),
        cameras=[_camera(reconstruction.cameras[image.camera_id]) for image in posed],
        sequences=[str(Path(name).parent) for name in names],
        points=partial(points_of, reconstruction, {i.image_id: at for at, i in enumerate(posed)}),
        dropped={i.name: "no pose" for i in reconstruction.images.values() if not i.has_pose},
    )


def _image_files(images: Path, names: list[str], model: Path) -> list[Path]:
    """Files by name; where downscaled copies have other endings, by their sorted order."""
    files = [images / name for name in names]
    if all(file.is_file() for file in files):
        return files
    by_stem = {file.stem: file for file in sorted(images.iterdir()) if file.is_file()}
    found = [by_stem.get(Path(name).stem) for name in names]
    missing = [name for name, file in zip(names, found, strict=True) if file is None]
    if missing:
        raise FileNotFoundError(
            f"{images / missing[0]}: image of {model} is missing ({len(missing)} in all)"
        )
    return found


def _camera(camera: pycolmap.Camera) -> Camera:
    return Camera(camera.model_name, camera.width, camera.height, tuple(camera.params))


def points_of(reconstruction: pycolmap.Reconstruction, rows: dict[int, int]) -> RawPoints | None:
    """Sparse points with tracks over the frames that `rows` numbers; None where there are none."""
    if not reconstruction.points3D:
        return None
    xyz, rgb, point, frame = [], [], [], []
    for at, key in enumerate(sorted(reconstruction.points3D)):
        entry = reconstruction.points3D[key]
        xyz.append(entry.xyz)
        rgb.append(entry.color)
        seen = sorted({rows[e.image_id] for e in entry.track.elements if e.image_id in rows})
        point += [at] * len(seen)
        frame += seen
    return RawPoints(
        np.array(xyz), np.array(rgb, np.uint8), np.array(point, np.int64), np.array(frame, np.int64)
    )


def build_model(recording: Recording, camera: Camera, names: list[str], keep: np.ndarray):
    """A pycolmap model of a recording's kept frames, its observations scaled to `camera`."""
    model = pycolmap.Reconstruction()
    model.add_camera_with_trivial_rig(
        pycolmap.Camera(
            camera_id=1,
            model=camera.model,
            width=camera.width,
            height=camera.height,
            params=list(camera.params),
        )
    )
    scale = camera.width / recording.camera.width
    order = np.argsort(recording.track_frame, kind="stable")
    starts = np.searchsorted(recording.track_frame[order], np.arange(len(names) + 1))
    tracks = [pycolmap.Track() for _ in recording.xyz]
    for i in np.flatnonzero(keep):
        rows = order[starts[i] : starts[i + 1]]
        pose = recording.world_to_camera[i]
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        image = pycolmap.Image(
            image_id=int(i) + 1,
            name=names[i],
            camera_id=1,
            keypoints=recording.track_xy[rows] * scale,
        )
        model.add_image_with_trivial_frame(image, rigid)
        for at, row in enumerate(rows):
            tracks[recording.track_point[row]].add_element(int(i) + 1, at)
    for xyz, rgb, track in zip(recording.xyz, recording.rgb, tracks, strict=True):
        if track.length() >= 2:
            model.add_point3D(xyz, track, rgb)
    return model


def scaled(camera: Camera, factor: int) -> Camera:
    """The same camera as if its images were `factor` times larger; distortion is unitless."""
    lengths = {"PINHOLE": 4, "OPENCV": 4, "OPENCV_FISHEYE": 4}[camera.model]
    params = tuple(p * factor if i < lengths else p for i, p in enumerate(camera.params))
    return Camera(camera.model, camera.width * factor, camera.height * factor, params)


def write_binary(model: pycolmap.Reconstruction, folder: Path) -> None:
    """Write a model's binary files into a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    model.write_binary(str(folder))


LAYOUT = Layout("colmap", lambda folder: find_model(folder) is not None, read)
