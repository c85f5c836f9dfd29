"""The standard `.ply` of 3D Gaussian splatting (Kerbl et al. 2023), through plyfile."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np
from plyfile import PlyData, PlyElement, PlyParseError

from fsel.captures.layouts.ply_points import check_counts

POSITION = ("x", "y", "z")
NORMAL = ("nx", "ny", "nz")  # written as zeros: viewers expect the columns
CONSTANT = ("f_dc_0", "f_dc_1", "f_dc_2")
SCALE = ("scale_0", "scale_1", "scale_2")
TURN = ("rot_0", "rot_1", "rot_2", "rot_3")
RESTS = (0, 9, 24, 45)  # columns of the higher harmonics, by degree
BACKGROUND = "background"  # the comment that holds the colour behind the Gaussians
SH_CONSTANT = 0.28209479177387814  # of the degree-zero spherical harmonic
LARGEST = 1e15  # of a value that is read


@dataclass(frozen=True)
class Cloud:
    """Content of such a file; `background` is the (3,) colour in [0, 1] behind the Gaussians."""

    xyz: np.ndarray  # (n, 3) positions, world units
    harmonics: np.ndarray  # (n, (degree + 1)^2, 3) of the colour's spherical harmonics
    logit: np.ndarray  # (n,) of the opacities
    log_scale: np.ndarray  # (n, 3) logarithms of the standard deviations, world units
    turn: np.ndarray  # (n, 4) quaternions w, x, y, z
    background: np.ndarray = field(default_factory=lambda: np.zeros(3, np.float32))

    @property
    def degree(self) -> int:
        """Degree of the harmonics."""
        return RESTS.index(3 * (self.harmonics.shape[1] - 1))


def write(place: str | Path | BinaryIO, cloud: Cloud) -> None:
    """Write a cloud to a file or stream, binary little-endian, all numbers float32."""
    count, rests = len(cloud.xyz), RESTS[cloud.degree]
    # the file holds all coefficients of red, then of green, then of blue
    rest = cloud.harmonics[:, 1:].transpose(0, 2, 1).reshape(count, rests)
    columns = {
        POSITION: cloud.xyz,
        NORMAL: np.zeros((count, 3)),
        CONSTANT: cloud.harmonics[:, 0],
        _rest_names(rests): rest,
        ("opacity",): cloud.logit[:, None],
        SCALE: cloud.log_scale,
        TURN: cloud.turn,
    }
    names = [name for group in columns for name in group]
    vertices = np.empty(count, [(name, "<f4") for name in names])
    for group, values in columns.items():
        for name, column in zip(group, values.T, strict=True):
            vertices[name] = column
    red, green, blue = (float(c) for c in cloud.background)
    comments = [f"{BACKGROUND} {red:.9g} {green:.9g} {blue:.9g}"]
    element = PlyElement.describe(vertices, "vertex")
    PlyData([element], byte_order="<", comments=comments).write(
        str(place) if isinstance(place, str | Path) else place
    )


def write_round(
    path: str | Path, xyz: np.ndarray, rgb: np.ndarray, opacity: np.ndarray, scale: np.ndarray
) -> None:
    """Write isotropic Gaussians of one colour each.

    Args:
        path: file to write.
        xyz: (n, 3) positions, world units.
        rgb: (n, 3) in [0, 1].
        opacity: (n,) in (0, 1).
        scale: (n,) standard deviations, world units.
    """
    clipped = np.clip(opacity, 1e-4, 1 - 1e-4)
    log_scale = np.log(np.maximum(scale, 1e-12))
    cloud = Cloud(
        xyz=xyz,
        harmonics=((rgb - 0.5) / SH_CONSTANT)[:, None],
        logit=np.log(clipped / (1 - clipped)),
        log_scale=np.repeat(log_scale[:, None], 3, axis=1),
        turn=np.tile([1.0, 0, 0, 0], (len(xyz), 1)),
    )
    write(path, cloud)


def check_filled(path: str | Path, gaussians: int) -> None:
    """Refuse a model of no Gaussians, of which a picture shows the background alone."""
    if not gaussians:
        raise ValueError(f"{path}: contains no Gaussians")


def read(path: str | Path) -> Cloud:
    """Read a standard `.ply` of Gaussians, binary or text, harmonics to degree three.

    Raises:
        ValueError: naming the file, for what is no such file, or values that are not finite or
            too large for products of theirs to be numbers in float32.
    """
    if Path(path).exists() and not Path(path).is_file():
        raise ValueError(f"{path}: no .ply file: not a regular file")
    try:
        check_counts(path)
        data = PlyData.read(str(path))
    except (PlyParseError, ValueError) as error:
        raise ValueError(f"{path}: no .ply file: {error}") from error
    if "vertex" not in data:
        raise ValueError(f"{path}: no element 'vertex'")
    vertices = data["vertex"].data
    names = vertices.dtype.names
    rests = sum(name.startswith("f_rest_") for name in names)
    needed = (*POSITION, *CONSTANT, *_rest_names(rests), "opacity", *SCALE, *TURN)
    missing = [name for name in needed if name not in names]
    if missing or rests not in RESTS:
        what = f"lacks {', '.join(missing)}" if missing else f"has {rests} columns f_rest_*"
        raise ValueError(
            f"{path}: no Gaussians: {what}. Allowed: the columns of Kerbl et al. 2023, with "
            f"{', '.join(map(str, RESTS))} columns f_rest_* (degrees 0 to 3)"
        )
    with np.errstate(invalid="ignore"):  # a signalling NaN, which is refused below
        values = np.stack([vertices[name].astype(np.float64) for name in needed], axis=1)
    for row, column in np.argwhere(~(np.abs(values) <= LARGEST))[:1]:
        what = f"{needed[column]} of Gaussian {row} is {values[row, column]}"
        raise ValueError(f"{path}: {what}; allowed: -{LARGEST:g} to {LARGEST:g}")
    return _cloud(values, rests, _background(data.comments, path))


def _cloud(values: np.ndarray, rests: int, background: np.ndarray) -> Cloud:
    xyz, constant, rest, logit, scale, turn = np.split(values, np.cumsum([3, 3, rests, 1, 3]), 1)
    turn[~turn.any(axis=1), 0] = 1  # no rotation is written as zeros by some
    rest = rest.reshape(len(values), 3, rests // 3).transpose(0, 2, 1)
    harmonics = np.concatenate([constant[:, None], rest], axis=1)
    return Cloud(xyz, harmonics, logit[:, 0], scale, turn, background)


def _rest_names(count: int) -> tuple[str, ...]:
    return tuple(f"f_rest_{k}" for k in range(count))


def _background(comments: list[str], path: str | Path) -> np.ndarray:
    for comment in comments:
        words = comment.split()
        if words[:1] == [BACKGROUND] and len(words) == 4:
            try:
                colour = np.array(words[1:], np.float32)
            except ValueError:
                colour = np.full(3, np.nan, np.float32)
            if not np.isfinite(colour).all():
                raise ValueError(f"{path}: comment {comment!r} holds no colour")
            return colour
    return np.zeros(3, np.float32)
