"""The points of a `.ply` that a capture names, which say nothing of who saw them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyParseError

from fsel.captures.parsing import regular
from fsel.core.geometry import MOST_LENGTH
from fsel.core.points import NO_POINTS, RawPoints

PLACE, COLOUR = ("x", "y", "z"), ("red", "green", "blue")
HEADER = 1 << 16  # bytes that are looked at for the header
GREY = 128  # of points without a colour


def read(path: Path, applied: np.ndarray | None, scale: float) -> RawPoints:
    """Return a file's finite points, without tracks and the (3, 4) world transform they carry."""
    if not path.exists():
        raise ValueError(f"{path}: file of points is missing")
    try:
        check_counts(regular(path))
        content = PlyData.read(str(path))
        vertices = content["vertex"].data
        with np.errstate(invalid="ignore"):  # a signalling NaN, which is refused below
            xyz = np.stack([vertices[name] for name in PLACE], axis=1).astype(np.float64)
        rgb = _colours(vertices)
    except (OSError, PlyParseError, ValueError, KeyError, MemoryError) as error:
        raise ValueError(f"{path}: no .ply file of points: {error}") from error
    for row in np.flatnonzero(~(np.abs(xyz) < MOST_LENGTH).all(axis=1))[:1]:
        raise ValueError(f"{path}: point {row} lies at {xyz[row].tolist()}, not finite")
    xyz = xyz / scale
    if applied is not None:
        xyz = (xyz - applied[:, 3]) @ np.linalg.inv(applied[:, :3]).T
    return replace(NO_POINTS, xyz=xyz, rgb=rgb)


def check_counts(path: str | Path) -> None:
    """Refuse a header that counts more rows than the file has bytes."""
    size = Path(path).stat().st_size
    with open(path, "rb") as file:
        header = file.read(HEADER).partition(b"end_header")[0]
    for count in map(int, re.findall(rb"^element \S+ (\d+)", header, re.M)):
        if count > size:
            raise ValueError(f"its header counts {count} rows, and it has {size} bytes")


def _colours(vertices: np.ndarray) -> np.ndarray:
    """Return (M, 3) uint8; colours that are no bytes count from 0 to 1."""
    if not set(COLOUR) <= set(vertices.dtype.names or ()):
        return np.full((len(vertices), 3), GREY, np.uint8)
    rgb = np.stack([vertices[name] for name in COLOUR], axis=1)
    if rgb.dtype.kind == "O":
        raise ValueError("a colour is a list; allowed: a number")
    if rgb.dtype.kind == "f":
        rgb = np.clip(np.nan_to_num(rgb), 0, 1) * 255
    return np.clip(np.round(rgb), 0, 255).astype(np.uint8)
