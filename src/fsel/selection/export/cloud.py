"""The sparse points that a subset is written with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import is_straight, straight
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.lazy import LazyCapture, open_images
from fsel.captures.poses import sfm
from fsel.core.points import NO_POINTS, RawPoints, grouped_rows

SEEN, ALL, NONE = "seen", "all", "none"
POINTS = (SEEN, ALL, NONE)
LEAST_TRACK = 2  # picked frames that see a point: fewer could not have triangulated it
MATCHED_SIDE = 800  # pixels of images that are matched, where points must be made


def cloud_of(
    opened: LazyCapture, frames: list[int], picks: list[int], points: str, matched: bool = True
) -> RawPoints:
    """Points with their tracks in some frames, those kept that the picks see.

    Points without any track, as those of a `.ply`, are seen where they lie in an image, whatever
    hides them. Where the capture has no points, they are triangulated from matches of the picks.

    Args:
        opened: the capture.
        frames: numbers of frames, which the tracks will number.
        picks: those of the frames that are trained on, without which no point is kept.
        points: `seen`: points that two picks see; `all`: every point of the capture; `none`.
        matched: whether points may be triangulated, which opens images.
    """
    if points == NONE:
        return NO_POINTS
    sparse = opened.raw.subset(frames).sparse()
    if sparse is None:
        sparse = _triangulated(opened, frames, picks) if matched else NO_POINTS
    if points == ALL:
        return sparse
    if not len(sparse.track_point):
        return sparse.subset(_held(opened.raw.subset(picks), sparse.xyz) >= LEAST_TRACK)
    chosen = np.isin(sparse.track_frame, np.searchsorted(frames, picks))
    seen = np.bincount(sparse.track_point[chosen], minlength=len(sparse.xyz))
    return sparse.subset(seen >= LEAST_TRACK)


def straightened(points: RawPoints, cameras: Sequence[Camera]) -> RawPoints:
    """The points as images without distortion show them; what these do not show is left out.

    Args:
        points: their tracks number the frames.
        cameras: one a frame, as its images are.
    """
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


def _held(raw: RawCapture, xyz: np.ndarray) -> np.ndarray:
    """(M,) how many images hold each point, by their cameras."""
    count = np.zeros(len(xyz), np.int64)
    for frame, camera in enumerate(raw.cameras):
        ahead, at = raw.projected(frame, xyz)
        count[ahead[_inside(at, camera)]] += 1
    return count


def _triangulated(opened: LazyCapture, frames: list[int], picks: list[int]) -> RawPoints:
    """Points from matches of the picks' images and their known poses."""
    made = sfm.triangulate(open_images(opened, picks, MATCHED_SIDE))
    if made is None:
        return NO_POINTS
    rows = np.searchsorted(frames, picks)
    at = rows[made.track_frame]
    return RawPoints(
        xyz=made.xyz,
        rgb=made.rgb,
        track_point=made.track_point,
        track_frame=at,
        track_xy=_seen_at(opened.raw.subset(frames), made.xyz[made.track_point], at),
    )


def _seen_at(raw: RawCapture, xyz: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """(L, 2) pixels at which frames see points, by their cameras, distortion included."""
    out = np.zeros((len(xyz), 2))
    for frame in np.unique(frames):
        rows = frames == frame
        pose = raw.world_to_camera[frame]
        local = xyz[rows] @ pose[:, :3].T + pose[:, 3]
        out[rows] = raw.cameras[frame].colmap.img_from_cam(local)
    return out
