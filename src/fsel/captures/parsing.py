"""Text, JSON and numbers out of files, refused by the name of the file and of the field."""

from __future__ import annotations

import gzip
import json
import math
import os
import zlib
from collections.abc import Iterable
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np

SINGULAR = 1e-9  # least determinant of a transform that can be undone
GZIP = b"\x1f\x8b"  # how a compressed file begins
LEAST_TURN = 0.5  # length of a quaternion; others off from 1 are refused as matrices


def regular(path: Path) -> Path:
    """Return a path, refused where it leads to a device or a pipe, which have no end."""
    if path.exists() and not path.is_file():
        raise OSError("not a regular file")
    return path


def read_text(path: Path) -> str:
    """Read a text file, naming it when it cannot be read."""
    try:
        return regular(path).read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise ValueError(f"{path}: no such file") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: is not a text file") from error
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: not readable as text ({error})") from error


def read_json(path: Path) -> dict[str, Any]:
    """Parse a JSON object, naming the file when that fails."""
    content = _parsed(path)
    if not isinstance(content, dict):
        raise ValueError(f"{path}: expected a JSON object, got {type(content).__name__}")
    return content


def read_json_list(path: Path) -> list[dict[str, Any]]:
    """Parse a list of JSON objects, perhaps gzipped, naming the file when that fails."""
    content = _parsed(path)
    if not isinstance(content, list) or not all(isinstance(entry, dict) for entry in content):
        raise ValueError(f"{path}: expected a JSON list of objects")
    return content


def _parsed(path: Path) -> object:
    try:
        content = regular(path).read_bytes()
        return json.loads(gzip.decompress(content) if content[:2] == GZIP else content)
    except (OSError, EOFError, ValueError, RecursionError, zlib.error) as error:
        raise ValueError(f"{path}: not readable as JSON ({error})") from error


def read_matrix(path: Path) -> np.ndarray:
    """Read a (4, 4) matrix of a text file; -inf and nan are numbers."""
    try:
        values = np.array(regular(path).read_text().split(), np.float64)
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: not readable as numbers ({error})") from error
    if values.size != 16:
        raise ValueError(f"{path}: expected a 4x4 matrix, got {values.size} numbers")
    return values.reshape(4, 4)


def member(entry: object, key: str, path: Path, where: str = "") -> object:
    """Return a value of a JSON object, naming file and field when it is not there."""
    if not isinstance(entry, dict) or entry.get(key) is None:
        raise ValueError(f"{path}: {where + ': ' if where else ''}field {key!r} is missing")
    return entry[key]


def text(entry: object, key: str, path: Path, where: str = "") -> str:
    """Return a string of a JSON object, naming file and field when it is none."""
    value = member(entry, key, path, where)
    if not isinstance(value, str):
        raise ValueError(f"{path}: {where + ': ' if where else ''}field {key!r} must be a string")
    return value


def numbers(value: object, shape: tuple[int, ...], path: Path, what: str) -> np.ndarray:
    """Return a JSON value as a float64 array of a given shape, naming file and field otherwise."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != shape:
        wanted = "x".join(map(str, shape)) or "one number"
        raise ValueError(f"{path}: {what} must be {wanted}, got {repr(value)[:80]}")
    return array


def number(value: object, path: Path, what: str) -> float:
    """Return a JSON value as a finite number, naming file and field otherwise."""
    scalar = float(numbers(value, (), path, what))
    if not math.isfinite(scalar):
        raise ValueError(f"{path}: {what} must be finite, got {scalar}")
    return scalar


def stated(entry: object, key: str, path: Path, where: str = "") -> float:
    """Return a finite number of a JSON object, naming file and field when it is none."""
    return number(member(entry, key, path, where), path, f"{where + ': ' if where else ''}{key}")


def check_turn(quaternion: Iterable[float], path: Path, what: str) -> None:
    """Refuse a quaternion far from unit length, which normalising could make any turn, or none."""
    length = math.hypot(*quaternion)
    if not LEAST_TURN < length < 1 / LEAST_TURN:
        raise ValueError(
            f"{path}: {what} has a quaternion of length {length:.3g}, which is not a rotation; "
            "allowed: 1"
        )


def world_transform(stored: object, path: Path, what: str) -> np.ndarray:
    """Return a JSON value as a (3, 4) transform that can be undone, naming file and field."""
    matrix = numbers(stored, (3, 4), path, what)
    if not np.isfinite(matrix).all() or not abs(np.linalg.det(matrix[:, :3])) >= SINGULAR:
        raise ValueError(f"{path}: {what} cannot be inverted: {repr(stored)[:200]}")
    return matrix


def slashed(name: str) -> str:
    r"""Return a path with slashes, where Windows wrote it: `images\a.png` is `images/a.png`."""
    return PureWindowsPath(name).as_posix() if "\\" in name else name


def inside(folder: Path, relative: str | Path, source: Path) -> Path:
    """Return a path that a file names, refused where it leads out of the capture."""
    path = Path(os.path.normpath(folder / relative))
    elsewhere = os.name != "nt" and PureWindowsPath(relative).drive
    if elsewhere or not path.is_relative_to(os.path.normpath(folder)):
        raise ValueError(f"{source}: file_path {str(relative)!r} leads outside {folder}")
    if not str(relative).isprintable():
        raise ValueError(f"{source}: file_path {str(relative)!r} has a control character")
    return path
