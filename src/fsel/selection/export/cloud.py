"""The sparse points that a subset is written with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsel.captures.canonical import ingest
from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import is_straight, straight
from fsel.captures.lazy import LazyCapture
from fsel.captures.poses import sfm
from fsel.core.points import NO_POINTS, RawPoints, grouped_rows

LEAST_TRACK = 2  # picked frames that see a point: fewer could not have triangulated it
MATCHED_SIDE = 800  # pixels of images that are matched, where points must be made


def cloud_of(
    opened: LazyCapture, frames: list[int], picks: list[int], matched: bool = True
) -> RawPoints:
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
