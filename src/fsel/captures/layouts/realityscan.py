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
from fsel.captures.parsing import read_text, stated, text
from fsel.core.geometry import from_opengl

MARK = b"#name,x,y,alt,"
RENAMED = {"yaw": "heading", "f_35mm": "f", "px_norm": "px", "py_norm": "py"}
"""Columns as newer versions name them."""
NEEDED = ("x", "y", "alt", "heading", "pitch", "roll", "f")
TERMS = ("px", "py", "k1", "k2", "k3", "k4", "t1", "t2")  # a template may leave them out
FILM = 36  # millimetres of the longer side, of which f is


def read(folder: Path) -> RawCapture:
    """Read a row a camera: its place, and angles in degrees; with all 0 it looks down, the top of
    its image to the north."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    path = only(marked(folder, "*.csv", MARK), folder, "CSV files of RealityScan's cameras")
    content = read_text(path)
    first, *lines = content[content.index(MARK.decode()) :].splitlines()
    header = [RENAMED.get(key, key) for key in first.split(",")]
    rows = [_values(row, path) for row in csv.DictReader(lines, header)]
    if not rows:
        raise ValueError(f"{path}: no camera below the header")
    files = images_of(folder, [name for name, _ in rows], path)
    place = np.array([[row["x"], row["y"], row["alt"]] for _, row in rows])
    angles = [[-row["heading"], row["pitch"], row["roll"]] for _, row in rows]
    turns = Rotation.from_euler("ZXY", angles, degrees=True).as_matrix()
    poses = near_origin(from_opengl(np.concatenate([turns, place[..., None]], axis=2)), path)
    sizes = {file: image_files.size_of(file) for file in files if file.is_file()}
    other = next(iter(sizes.values()), (1, 1))  # of a missing image, which is refused or left out
    frames = [
        (file, pose, _camera(row, sizes.get(file, other), path))
        for file, pose, (_, row) in zip(files, poses, rows, strict=True)
    ]
    return one_pass(frames, {})


def _values(row: dict[str, str], path: Path) -> tuple[str, dict[str, float]]:
    """Return a camera's name and its numbers."""
    name = text(row, "#name", path)
    row = dict.fromkeys(TERMS, "0") | row
    return name, {key: stated(row, key, path, name) for key in (*NEEDED, *TERMS)}


def _camera(row: dict[str, float], size: tuple[int, int], path: Path) -> Camera:
    """Return a camera of f in millimetres of 35 mm film, px and py from the image's middle as
    shares of its longer side; t1 and t2 stand the other way round than OpenCV's."""
    side = max(size)
    focal = row["f"] * side / FILM
    reach = math.hypot(*size) / 2 / max(abs(focal), 1e-9)
    negligible(focal * row["k4"] * reach**9, path, "k4")
    pinhole = (focal, focal, size[0] / 2 + row["px"] * side, size[1] / 2 + row["py"] * side)
    return brown(size, pinhole, row["k1"], row["k2"], row["t2"], row["t1"], row["k3"])


LAYOUT = Layout("realityscan", lambda folder: bool(marked(folder, "*.csv", MARK)), read)
