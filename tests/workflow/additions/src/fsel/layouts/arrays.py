"""Images beside one file of poses and intrinsics."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.layouts import images
from fsel.layouts.base import Layout, RawCapture
from fsel.layouts.recording import Camera, Recording

CAMERAS = "cameras.npz"


def recognises(folder: Path) -> bool:
    """cameras.npz is there."""
    return (folder / CAMERAS).is_file()


def read(folder: Path) -> RawCapture:
    """Poses and the one camera from cameras.npz, whose names are those of the images."""
    with np.load(folder / CAMERAS) as stored:
        names = [str(name) for name in stored["names"]]
        width, height = (int(side) for side in stored["size"])
        camera = Camera(str(stored["model"]), width, height, tuple(stored["params"].tolist()))
        poses = stored["poses"]
    return RawCapture(
        names=names,
        images=[folder / name for name in names],
        world_to_camera=poses,
        cameras=[camera] * len(names),
        sequences=["capture"] * len(names),
    )


def write(recording: Recording, folder: Path) -> None:
    """A .png a frame, and cameras.npz."""
    camera, names = recording.camera, [f"{name}.png" for name in recording.names]
    images.write(recording.images, folder, names)
    np.savez(
        folder / CAMERAS,
        names=names,
        poses=recording.world_to_camera,
        model=camera.model,
        size=(camera.width, camera.height),
        params=camera.params,
    )


LAYOUT = Layout("arrays", recognises, read, write)
