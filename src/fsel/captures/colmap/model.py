"""COLMAP models of cameras, poses and points, as pycolmap writes them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fsel.captures.colmap.bindings import pycolmap


def build_model(
    names: Sequence[str],
    cameras: Sequence[pycolmap.Camera],
    world_to_camera: np.ndarray,
    xyz: np.ndarray,
    rgb: np.ndarray,
    seen: Sequence[np.ndarray],
    pixels: Sequence[np.ndarray],
    *,
    error: np.ndarray | None = None,
    ids: Sequence[int] | None = None,
    least: int = 0,
) -> pycolmap.Reconstruction:
    """A model of images and points.

    Args:
        names: n names of images.
        cameras: n; those of equal model, size and parameters become one camera.
        world_to_camera: (n, 3, 4).
        xyz, rgb: (M, 3) points, world units, and their colours, uint8.
        seen: n arrays, the points that each image sees.
        pixels: n arrays (., 2), where it sees them.
        error: (M,) mean reprojection errors of the points, pixels; None where not known.
        ids: n distinct numbers of the images; None for 1 to n.
        least: images that must see a point, or it is left out.
    """
    model, numbers = pycolmap.Reconstruction(), dict[tuple, int]()
    tracks = [pycolmap.Track() for _ in xyz]
    ids = range(1, len(names) + 1) if ids is None else ids
    for i, camera in enumerate(cameras):
        key = (camera.model, camera.width, camera.height, *camera.params)
        if key not in numbers:
            camera.camera_id = numbers[key] = len(numbers) + 1
            model.add_camera_with_trivial_rig(camera)
        image = pycolmap.Image(
            image_id=ids[i], name=names[i], camera_id=numbers[key], keypoints=pixels[i]
        )
        pose = world_to_camera[i]
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        model.add_image_with_trivial_frame(image, rigid)
        for at, point in enumerate(seen[i]):
            tracks[point].add_element(ids[i], at)
    for at, (point, track, color) in enumerate(zip(xyz, tracks, rgb, strict=True)):
        if track.length() >= least:
            key = model.add_point3D(point, track, color)
            if error is not None:
                model.points3D[key].error = error[at]
    return model


def write_binary(model: pycolmap.Reconstruction, folder: Path) -> None:
    """Write a model's binary files into a folder, which is made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    model.write_binary(str(folder))


def write_capture_model(model: pycolmap.Reconstruction, folder: Path, cloud: Path) -> bool:
    """Write a model where trainers look for it, `sparse/0`, and its points as a `.ply`.

    Args:
        model: to write.
        folder: of the capture.
        cloud: file of the points, made where there are some.

    Returns:
        Whether there are points.
    """
    write_binary(model, folder / "sparse" / "0")
    if model.points3D:
        model.export_PLY(str(cloud))
    return bool(model.points3D)
