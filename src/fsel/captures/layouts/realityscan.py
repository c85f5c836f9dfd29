"""RealityScan's, once RealityCapture's, internal and external camera parameters in CSV."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera, brown
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.layouts.exports import images_of, marked, near_origin, negligible, only
from fsel.captures.parsing import number, read_text
from fsel.core.geometry import from_opengl

MARK = b"#name,x,y,alt,"
RENAMED = {"yaw": "heading", "f_35mm": "f", "px_norm": "px", "py_norm": "py"}
"""Columns as newer versions name them."""
NEEDED = ("#name", "x", "y", "alt", "heading", "pitch", "roll", "f")
FILM = 36  # millimetres of the longer side, of which f is
HINT = "align with the distortion model Brown3, or export undistorted images"


def read(folder: Path) -> RawCapture:
    """Read a row a camera: its place, and angles in degrees; with all 0 it looks down, the top of
    its image to the north."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    path = only(marked(folder, "*.csv", MARK), folder, "CSV files of RealityScan's cameras")
    names, rows = _rows(path)
    files = images_of(folder, names, path)
    angles = [[-row["heading"], row["pitch"], row["roll"]] for row in rows]
    turns = Rotation.from_euler("ZXY", angles, degrees=True).as_matrix()
    places = np.array([[row["x"], row["y"], row["alt"]] for row in rows])
    poses = near_origin(from_opengl(np.concatenate([turns, places[..., None]], axis=2)), path)
    there = [file for file in files if file.is_file()]
    sizes = {file: image_files.size_of(file) for file in there}
    cameras = [  # an image that is missing is refused later, or left out
        _camera(row, sizes.get(file) or sizes.get(there[0], (1, 1)), path)
        for file, row in zip(files, rows, strict=True)
    ]
    return one_pass(list(zip(files, poses, cameras, strict=True)), {})


def _rows(path: Path) -> tuple[list[str], list[dict[str, float]]]:
    """Return the names, and the numbers by column; columns that a template left out are 0."""
    lines = read_text(path).splitlines()
    first = next(at for at, line in enumerate(lines) if line.startswith(MARK.decode()))
    header = [RENAMED.get(key, key) for key in lines[first].split(",")]
    if absent := [key for key in NEEDED if key not in header]:
        raise ValueError(f"{path}: no column {', '.join(absent)}; there are {', '.join(header)}")
    names, rows = [], []
    for at, fields in enumerate(csv.reader(lines[first + 1 :]), start=first + 2):
        if len(fields) != len(header):
            raise ValueError(f"{path}: line {at} has {len(fields)} fields; allowed: {len(header)}")
        pairs = list(zip(header[1:], fields[1:], strict=True))
        names.append(fields[0])
        rows.append({key: number(field, path, f"{key} in line {at}") for key, field in pairs})
    if not rows:
        raise ValueError(f"{path}: no camera below the header")
    return names, rows


def _camera(row: dict[str, float], size: tuple[int, int], path: Path) -> Camera:
    """Return a camera of f in millimetres of 35 mm film, px and py from the image's middle as
    shares of its longer side; t1 and t2 stand the other way round than OpenCV's."""
    value = {key: row.get(key, 0.0) for key in ("px", "py", "k1", "k2", "k3", "k4", "t1", "t2")}
    side = max(size)
    focal = row["f"] * side / FILM
    reach = math.hypot(*size) / 2 / max(abs(focal), 1e-9)
    negligible(focal * value["k4"] * reach**9, path, "k4", HINT)
    middle = (size[0] / 2 + value["px"] * side, size[1] / 2 + value["py"] * side)
    terms = (value["k1"], value["k2"], value["t2"], value["t1"], value["k3"])
    return brown(size, (focal, focal, *middle), *terms)


LAYOUT = Layout("realityscan", lambda folder: bool(marked(folder, "*.csv", MARK)), read)
