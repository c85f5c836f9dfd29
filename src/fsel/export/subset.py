"""A selection as captures that trainers read: images, transforms.json, a COLMAP model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsel.colmap.camera import Camera
from fsel.data.points import RawPoints, SparsePoints
from fsel.export import cloud, placing
from fsel.export.forms import DISTORTION, Subset, transforms, write_forms, write_json
from fsel.images import files as image_files
from fsel.ingest.lazy import LazyCapture
from fsel.layouts.contract import RawCapture

TRAIN, TEST = "train", "test"
SPLIT = "transforms_split.json"  # of both folders, for nerfstudio, which reads the lists in it


@dataclass(frozen=True)
class Form:
    """Form in which images and points are written.

    Attributes:
        link: as hard links; else as copies.
        long_side: pixels of the images' longer side; None as they are.
        points: one of `fsel.export.cloud.POINTS`.
        matched: triangulate points from matches of images where the capture has none.
        shapes: folder of an object's masks; a frame without one shows nothing of it.
    """

    link: bool = False
    long_side: int | None = None
    points: str = cloud.SEEN
    matched: bool = True
    shapes: Path | None = None


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
    stage: Path, opened: LazyCapture, picks: np.ndarray, held: np.ndarray, form: Form
) -> SparsePoints:
    """Write the picks as a capture; with held-out frames, `train` and `test`, a capture each.

    Trainers that hold frames out by themselves, or that ignore the lists of transforms.json, then
    cannot train on what is held out. Both have the points that the picks see. Where there are
    masks, of the object or else the capture's own, each image gets one of its size, white where
    pixels count.

    Args:
        stage: folder to fill.
        opened: the capture, its cameras checked by `check_cameras`.
        picks: (k,) frames to train on.
        held: (F,) frames to evaluate on.
        form: how.

    Returns:
        The points that were written.

    Raises:
        ValueError: for a frame whose name leads out of the folder, or an unreadable image.
    """
    train, kept_back = np.sort(picks).tolist(), np.sort(held).tolist()
    used = sorted(train + kept_back)
    cameras = dict(zip(used, true_cameras(opened.raw, used, form.long_side), strict=True))
    points = cloud.cloud_of(opened, used, train, form.points, form.matched)
    scene = Path(opened.capture.source).resolve().name
    if not kept_back:
        part = _written(stage, opened.raw, train, used, cameras, points, form)
        write_forms(part, stage, scene)
        return points.without_pixels()
    parts = []
    for folder, frames in ((TRAIN, train), (TEST, kept_back)):
        part = _written(stage / folder, opened.raw, frames, used, cameras, points, form)
        write_forms(part, stage / folder, f"{scene}_{folder}")
        parts.append((part, f"{folder}/"))
    lists = [[f"{folder}images/{name}" for name in part.names] for part, folder in parts]
    content = transforms(parts, len(points.xyz) > 0)
    keys = ("train_filenames", "val_filenames", "test_filenames")
    write_json(content | dict(zip(keys, (*lists, lists[1]), strict=True)), stage / SPLIT)
    return points.without_pixels()


def _written(
    folder: Path,
    raw: RawCapture,
    frames: list[int],
    used: list[int],
    cameras: dict[int, Camera],
    points: RawPoints,
    form: Form,
) -> Subset:
    """Images and masks of some frames, in a folder, and what forms are written from."""
    names, resized = [], form.long_side is not None
    for i in frames:
        name = placing.file_name(raw, i, resized)
        size = (cameras[i].width, cameras[i].height)
        target = placing.inside(folder / "images", name)
        placing.place(raw.images[i], target, form.link, size if resized else None)
        names.append(name)
    masked = form.shapes is not None or raw.masks is not None
    for i, name in zip(frames, names, strict=True) if masked else ():
        mask = placing.mask(raw, i, form.shapes, (cameras[i].width, cameras[i].height))
        image_files.write(mask[None], folder / "masks", [f"{name}.png"])
    return Subset(
        names=names,
        cameras=[cameras[i] for i in frames],
        stated=[(raw.cameras[i].width, raw.cameras[i].height) for i in frames],
        world_to_camera=raw.world_to_camera[frames],
        points=cloud.as_seen_by(points, [used.index(i) for i in frames]),
        masked=masked,
    )


def true_cameras(
    raw: RawCapture, frames: Sequence[int], long_side: int | None = None
) -> list[Camera]:
    """Cameras at the size that their images will have, as one image of each camera has it.

    Args:
        raw: the capture.
        frames: n numbers.
        long_side: pixels that the longer side is reduced to; None as it is.
    """
    true: dict[Camera, Camera] = {}
    for i in frames:
        camera = raw.cameras[i]
        if camera not in true:
            width, height = image_files.size_of(raw.images[i])
            scale = min(1.0, (long_side or np.inf) / max(width, height))
            size = max(1, round(width * scale)), max(1, round(height * scale))
            scaled = camera.colmap
            scaled.rescale(*size)
            true[camera] = Camera(camera.model, *size, tuple(scaled.params))
    return [true[raw.cameras[i]] for i in frames]
