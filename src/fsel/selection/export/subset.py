"""A selection as captures that trainers read: images, transforms.json, a COLMAP model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from fsel.captures.canonical import ingest
from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import Lens, is_straight, straight
from fsel.captures.forms import Subset, transforms, write_forms, write_json
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.layouts.nerfstudio import COEFFICIENTS
from fsel.captures.lazy import LazyCapture
from fsel.captures.poses import sfm
from fsel.core.points import NO_POINTS, RawPoints, SparsePoints, grouped_rows
from fsel.selection.export import placing

LENSES = 2  # kept at once: the tables of a large image take as much as the image
FRAMES = "frames.txt"
TRAIN, TEST = "train", "test"
SPLIT = "transforms_split.json"  # of both folders, for nerfstudio, which reads the lists in it

LEAST_TRACK = 2  # picked frames that see a point: fewer could not have triangulated it
MATCHED_SIDE = 800  # pixels of images that are matched, where points must be made


@dataclass(frozen=True)
class Form:
    """Form in which images and points are written.

    Attributes:
        link: as hard links; else as copies.
        long_side: pixels of the images' longer side; None as they are.
        matched: triangulate points from matches of images where the capture has none.
        shapes: folder of an object's masks; a frame without one shows nothing of it.
        undistort: images and cameras without distortion.
    """

    link: bool = False
    long_side: int | None = None
    matched: bool = True
    shapes: Path | None = None
    undistort: bool = False


def check_cameras(raw: RawCapture, undistort: bool) -> None:
    """Refuse, before any work, cameras that nerfstudio does not have, or, with `undistort`, that
    cannot be undistorted."""
    for camera in dict.fromkeys(raw.cameras):
        if undistort:
            straight(camera)
        elif camera.model not in COEFFICIENTS:
            raise ValueError(
                f"camera model {camera.model} has no counterpart in transforms.json; allowed: "
                f"{', '.join(COEFFICIENTS)}. Hint: --undistort"
            )


def write(
    stage: Path, opened: LazyCapture, picks: np.ndarray, held_out: np.ndarray, form: Form
) -> SparsePoints:
    """Write frames.txt, and a capture of the picks; with held-out frames, `train` and `test` each.

    Trainers that ignore the lists of transforms.json then cannot train on held-out frames. Both
    have the points that the picks see, which are returned in the capture's world. Where there are
    masks, of the object or else the capture's own, each image gets one of its size, white where
    pixels count. The cameras were checked by `check_cameras`.
    """
    names = "".join(f"{opened.capture.names[i]}\n" for i in picks)
    (stage / FRAMES).write_text(names, encoding="utf-8")
    train, kept_back = np.sort(picks).tolist(), np.sort(held_out).tolist()
    used = sorted(train + kept_back)
    cameras = dict(zip(used, true_cameras(opened.raw, used, form), strict=True))
    points = cloud_of(opened, used, train, form.matched)
    own = points.without_pixels()
    if form.undistort:
        points = straightened(points, [opened.raw.cameras[i] for i in used])
    raw = opened.raw
    scene = Path(opened.capture.source).resolve().name
    if not kept_back:
        part = _written(stage, raw, train, used, cameras, points, form)
        write_forms(part, stage, scene)
        return own
    parts = []
    for folder, frames in ((TRAIN, train), (TEST, kept_back)):
        part = _written(stage / folder, raw, frames, used, cameras, points, form)
        write_forms(part, stage / folder, f"{scene}_{folder}")
        parts.append((part, f"{folder}/"))
    lists = [[f"{folder}images/{name}" for name in part.names] for part, folder in parts]
    content = transforms(parts, len(points.xyz) > 0)
    keys = ("train_filenames", "val_filenames", "test_filenames")
    write_json(content | dict(zip(keys, (*lists, lists[1]), strict=True)), stage / SPLIT)
    return own


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
    names, lens_of = [], lru_cache(maxsize=LENSES)(Lens)
    for i in frames:
        camera, size = raw.cameras[i], (cameras[i].width, cameras[i].height)
        lens = None
        if form.undistort and not is_straight(camera):
            lens = lens_of(camera, image_files.size_of(raw.images[i]), max(size))
        changed = lens is not None or form.long_side is not None
        name = placing.file_name(raw, i, changed)
        target = placing.inside(folder / "images", name)
        placing.place(raw.images[i], target, form.link, size if changed else None, lens)
        names.append(name)
    masked = form.shapes is not None or raw.masks is not None
    for i, name in zip(frames, names, strict=True) if masked else ():
        size = (cameras[i].width, cameras[i].height)
        mask = placing.mask(raw, i, form.shapes, size, form.undistort)
        image_files.write(mask[None], folder / "masks", [f"{name}.png"])
    return Subset(
        names=names,
        cameras=[cameras[i] for i in frames],
        stated=[(raw.cameras[i].width, raw.cameras[i].height) for i in frames],
        world_to_camera=raw.world_to_camera[frames],
        points=points.seen_from(np.searchsorted(used, frames), len(used)),
        masked=masked,
    )


def true_cameras(raw: RawCapture, frames: Sequence[int], form: Form) -> list[Camera]:
    """Cameras at the size that their images will have, as one image of each camera has it."""
    true: dict[Camera, Camera] = {}
    for i in frames:
        camera = raw.cameras[i]
        if camera not in true:
            width, height = image_files.size_of(raw.images[i])
            scale = min(1.0, (form.long_side or np.inf) / max(width, height))
            size = max(1, round(width * scale)), max(1, round(height * scale))
            scaled = (straight(camera) if form.undistort else camera).colmap
            scaled.rescale(*size)
            true[camera] = Camera(scaled.model_name, *size, tuple(scaled.params))
    return [true[raw.cameras[i]] for i in frames]


def cloud_of(opened: LazyCapture, frames: list[int], picks: list[int], matched: bool) -> RawPoints:
    """Points with their tracks, which number the frames; kept are those that two picks see.

    Points without any track, as those of a `.ply`, are seen where they lie in an image. Where the
    capture has no points, they are triangulated from matches of the picks, if they may be matched.
    """
    sparse = opened.raw.subset(frames).sparse()
    if sparse is None:
        sparse = _triangulated(opened, frames, picks) if matched else NO_POINTS
    if len(sparse.track_point):
        chosen = np.isin(sparse.track_frame, np.searchsorted(frames, picks))
        seen = np.bincount(sparse.track_point[chosen], minlength=len(sparse.xyz))
        return sparse.subset(seen >= LEAST_TRACK)
    raw, count = opened.raw.subset(picks), np.zeros(len(sparse.xyz), np.int64)
    for frame, camera in enumerate(raw.cameras):
        ahead, at = raw.projected(frame, sparse.xyz)
        count[ahead[_inside(at, camera)]] += 1
    return sparse.subset(count >= LEAST_TRACK)


def straightened(points: RawPoints, cameras: Sequence[Camera]) -> RawPoints:
    """The points as images without distortion show them, by the camera of each frame; what these do
    not show is left out."""
    xy = points.track_xy.copy()
    shown = np.ones(len(xy), bool)
    for camera, rows in zip(cameras, grouped_rows(points.track_frame, len(cameras)), strict=True):
        if len(rows) and not is_straight(camera):
            rays = np.asarray(camera.colmap.cam_from_img(xy[rows]))
            local = np.column_stack([rays, np.ones(len(rows))])
            xy[rows] = straight(camera).colmap.img_from_cam(local)
            shown[rows] = _inside(xy[rows], camera)
    return replace(points, track_xy=xy).observed(shown)


def _inside(xy: np.ndarray, camera: Camera) -> np.ndarray:
    """(n,) bool, which of (n, 2) pixels lie in a camera's image; none that are not finite."""
    return np.all((xy >= 0) & (xy <= (camera.width, camera.height)), axis=1)


def _triangulated(opened: LazyCapture, frames: list[int], picks: list[int]) -> RawPoints:
    """Points from matches of the picks' images and their known poses."""
    raw = opened.raw.subset(picks)
    made = sfm.triangulate(ingest(raw, opened.capture.source, MATCHED_SIDE, lazy=True))
    if made is None:
        return NO_POINTS
    xyz = made.xyz[made.track_point]
    xy = np.zeros((len(xyz), 2))
    for pick in np.unique(made.track_frame):
        rows, pose = made.track_frame == pick, raw.world_to_camera[pick]
        local = xyz[rows] @ pose[:, :3].T + pose[:, 3]
        xy[rows] = raw.cameras[pick].colmap.img_from_cam(local)
    at = np.searchsorted(frames, picks)[made.track_frame]
    return RawPoints(made.xyz, made.rgb, made.track_point, at, xy)
