"""OpenSfM's reconstruction.json with its tracks, which OpenDroneMap keeps in opensfm/."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.colmap.camera import Camera, brown
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.layouts.exports import images_of, marked, only
from fsel.captures.layouts.ply_points import GREY
from fsel.captures.parsing import member, numbers, read_json_list, read_text, stated, text
from fsel.core.geometry import pose_matrices
from fsel.core.points import RawPoints

PLACES = ("reconstruction.json", "opensfm/reconstruction.json")
TRACKS = "tracks.csv"
KINDS = ("perspective", "simple_radial", "radial", "brown", "fisheye", "fisheye_opencv")
TERMS = ("c_x", "c_y", "k1", "k2", "k3", "k4", "p1", "p2")


def read(folder: Path) -> RawCapture:
    """Read the largest reconstruction: shots turned by vectors, world to camera with OpenCV axes,
    and points, whose tracks are beside it."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    path = only(_files(folder), folder, PLACES[0])
    parts = [part for part in read_json_list(path) if isinstance(part.get("shots"), dict)]
    part = max(parts, key=lambda one: len(one["shots"]), default=None)
    if part is None or not part["shots"]:
        raise ValueError(f"{path}: no shots. Hint: nothing was reconstructed")
    shots, names = part["shots"], sorted(part["shots"])
    turns, shifts = (
        numbers(
            [member(shots[name], key, path, name) for name in names], (len(names), 3), path, key
        )
        for key in ("rotation", "translation")
    )
    poses = pose_matrices(Rotation.from_rotvec(turns).as_matrix(), shifts)
    lenses = {
        key: _camera(key, member(member(part, "cameras", path), key, path), path)
        for key in {text(shots[name], "camera", path, name) for name in names}
    }
    cameras = [lenses[shots[name]["camera"]] for name in names]
    frames = zip(images_of(folder, names, path), poses, cameras, strict=True)

    @cache
    def points(rows: tuple[int, ...]) -> RawPoints | None:
        return _points(part, [names[i] for i in rows], [cameras[i] for i in rows], path)

    others = {name for smaller in parts for name in smaller["shots"]} - set(names)
    dropped = dict.fromkeys(sorted(others), "in a smaller reconstruction")
    return replace(one_pass(list(frames), dropped), points=points)


def _camera(key: str, lens: Any, path: Path) -> Camera:
    """Return a camera, whose lengths are shares of the image's longer side, from its middle."""
    width, height = (int(stated(lens, side, path, key)) for side in ("width", "height"))
    kind = lens.get("projection_type", "perspective")
    if kind not in KINDS:
        raise ValueError(
            f"{path}: projection_type of camera {key!r} is {kind!r}; allowed: {', '.join(KINDS)}"
        )
    side, own = max(width, height), ("focal_x", "focal_y") if "focal_x" in lens else ("focal",) * 2
    fx, fy = (stated(lens, focal, path, key) * side for focal in own)
    lens = dict.fromkeys(TERMS, 0.0) | lens
    cx, cy, k1, k2, k3, k4, p1, p2 = (stated(lens, term, path, key) for term in TERMS)
    pinhole = (fx, fy, width / 2 + cx * side, height / 2 + cy * side)
    if "fisheye" in kind:
        return Camera("OPENCV_FISHEYE", width, height, (*pinhole, k1, k2, k3, k4))
    return brown((width, height), pinhole, k1, k2, p1, p2, k3)


def _points(part: dict, names: list[str], cameras: list[Camera], path: Path) -> RawPoints | None:
    """Return a reconstruction's points as frames see them by the table of tracks."""
    known = part.get("points")
    if not isinstance(known, dict) or not known:
        return None
    xyz = [member(point, "coordinates", path, key) for key, point in known.items()]
    rgb = [point.get("color", [GREY] * 3) for point in known.values()]
    frames, points = ({key: at for at, key in enumerate(keys)} for keys in (names, known))
    track, seen = [], path.parent / TRACKS
    for line in read_text(seen).splitlines() if seen.is_file() else ():
        image, point, _, *place = [*line.split("\t"), "", "", ""][:5]
        if image in frames and point in points:
            track.append((points[point], frames[image], *place))
    table = numbers(track or np.empty((0, 4)), (len(track), 4), seen, "tracks")
    at = table[:, 1].astype(np.int64)
    sizes = np.array([(camera.width, camera.height) for camera in cameras], np.float64)[at]
    made = RawPoints(
        xyz=numbers(xyz, (len(known), 3), path, "coordinates"),
        rgb=np.clip(numbers(rgb, (len(known), 3), path, "color"), 0, 255).astype(np.uint8),
        track_point=table[:, 0].astype(np.int64),
        track_frame=at,
        track_xy=table[:, 2:] * sizes.max(axis=1, keepdims=True) + sizes / 2,
    )
    made = made.observed(np.isfinite(made.track_xy).all(axis=1))
    return made.subset(np.isfinite(made.xyz).all(axis=1))


def _files(folder: Path) -> list[Path]:
    return [file for place in PLACES for file in marked(folder, place)]


LAYOUT = Layout("opensfm", lambda folder: bool(_files(folder)), read)
