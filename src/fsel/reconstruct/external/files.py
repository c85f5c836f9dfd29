"""What a worker gets: arrays in mapped files, and images with cameras as trainers read them.

images/000000.png ...   the selected frames, undistorted, in the capture's order
masks/000000.png.png .. white where a pixel counts, when the capture has masks
transforms.json         their cameras as nerfstudio states them, in the capture's own world
sparse/0/*.bin          their cameras as COLMAP states them, and the points that two of them see
sparse_pc.ply           those points
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.forms import Subset, write_trained
from fsel.core.capture import Capture, Views
from fsel.core.points import NO_POINTS, RawPoints

POINTS = ("xyz", "rgb", "track_point", "track_frame")


class Arrays:
    """A new folder of `.npy` files that stay mapped: making files takes milliseconds."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        self._mapped: dict[str, np.memmap] = {}

    def path(self, name: str) -> Path:
        """Return the file of an array."""
        return self.folder / f"{name}.npy"

    def room(self, name: str, shape: tuple[int, ...], kind: np.dtype) -> np.memmap:
        """Return a mapped array, with its former content."""
        found = self._mapped.get(name)
        if found is None or found.shape != shape or found.dtype != kind:
            path = self.path(name)
            path.unlink(missing_ok=True)
            found = np.lib.format.open_memmap(path, mode="w+", dtype=kind, shape=shape)
            self._mapped[name] = found
        return found

    def put(self, name: str, array: np.ndarray) -> Path:
        """Write an array; return its file."""
        self.room(name, array.shape, array.dtype)[...] = array
        return self.path(name)

    def put_frames(self, capture: Capture, points: bool) -> None:
        """Write the frames' images, masks and cameras, and the sparse points."""
        for name in ("images", "masks", "world_to_camera", "intrinsics"):
            if (array := getattr(capture, name)) is not None:
                self.put(name, array)
        if points and capture.points is not None:
            for name in POINTS:
                self.put(name, getattr(capture.points, name))

    def put_views(self, views: Views) -> Path:
        """Write a row for each view: its pose, then its intrinsics."""
        poses = views.world_to_camera.reshape(-1, 12)
        return self.put("views", np.concatenate([poses, views.intrinsics], axis=1))


def write_files(folder: Path, capture: Capture) -> None:
    """Write what the head of this module lists, of a capture of the selected frames alone."""
    names = [f"{row:06d}.png" for row in range(len(capture))]
    for row, name in enumerate(names):
        _write(folder / "images" / name, np.asarray(capture.images[row])[:, :, ::-1])
        if capture.masks is not None:
            mask = np.asarray(capture.masks[row]).astype(np.uint8) * 255
            _write(folder / "masks" / f"{name}.png", mask)
    pinholes = capture.intrinsics.tolist()
    cameras = [Camera("PINHOLE", *capture.size, tuple(params)) for params in pinholes]
    poses, masked = capture.world_to_camera, capture.masks is not None
    sizes = [capture.size] * len(names)
    write_trained(Subset(names, cameras, sizes, poses, _pixels(capture), masked), folder)


def _write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    if not cv2.imwrite(str(path), image):
        raise OSError(f"{path}: could not be written")


def _pixels(capture: Capture) -> RawPoints:
    """Return a capture's points, seen where its cameras project them."""
    points = capture.points or NO_POINTS
    poses, pinholes = (
        array[points.track_frame] for array in (capture.world_to_camera, capture.intrinsics)
    )
    turned = np.einsum("nij,nj->ni", poses[:, :, :3], points.xyz[points.track_point])
    local = turned + poses[:, :, 3]
    pixels = local[:, :2] / local[:, 2:] * pinholes[:, :2] + pinholes[:, 2:]
    return RawPoints(points.xyz, points.rgb, points.track_point, points.track_frame, pixels)
