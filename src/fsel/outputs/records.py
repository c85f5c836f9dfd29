"""The record in an output of the run that wrote it: nothing without one is ever replaced.

A folder holds `manifest.json`: the command, and every file's size and time of change. A `.ply` has
a comment in its header: the command, and a digest of the rest of the file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

MANIFEST = "manifest.json"
PLY = b"ply\n"
COMMENT = b"comment fsel "


class Foreign(Exception):
    """Why an output is not what a run of the command left behind."""


class Record(Protocol):
    """How a kind of output is begun, recorded when finished, and recognised later."""

    def begin(self, path: Path) -> None:
        """Make it, empty: where nothing can be written, that is refused before work."""

    def write(self, path: Path, command: str) -> None:
        """Record a finished output."""

    def read(self, path: Path, command: str) -> str:
        """What tells this output of the command from those of its other runs.

        Raises:
            Foreign: when it is no output of the command, or was changed since.
        """


class FolderRecord:
    """Of a folder."""

    def begin(self, path: Path) -> None:
        """See `Record`."""
        path.mkdir()

    def write(self, path: Path, command: str) -> None:
        """See `Record`."""
        files = {name: _stamp(path / name) for name in _files(path)}
        content = {"command": f"fsel {command}", "files": dict(sorted(files.items()))}
        (path / MANIFEST).write_text(json.dumps(content, indent=1), encoding="utf-8")

    def read(self, path: Path, command: str) -> str:
        """See `Record`."""
        if not path.is_dir():
            raise Foreign("it is no folder")
        try:
            text = (path / MANIFEST).read_text(encoding="utf-8")
            content = json.loads(text)
            files, by = dict(content["files"]), content["command"]
        except (OSError, ValueError, TypeError, KeyError, RecursionError):
            raise Foreign(f"it holds no {MANIFEST} of an earlier run") from None
        if by != f"fsel {command}":
            raise Foreign(f"it was written by {by!r}")
        for name in sorted(set(_files(path)) - {MANIFEST}):
            if name not in files:
                raise Foreign(f"it holds {name!r}, which no run wrote")
            if files[name] != _stamp(path / name):
                raise Foreign(f"its {name!r} was changed since")
        return text


class PlyRecord:
    """Of a `.ply` file."""

    def begin(self, path: Path) -> None:
        """See `Record`."""
        path.touch()

    def write(self, path: Path, command: str) -> None:
        """See `Record`."""
        content = path.read_bytes()
        if not content.startswith(PLY):
            raise ValueError(f"{path}: expected a .ply file to record")
        line = f"{command} {hashlib.sha256(content).hexdigest()}\n".encode()
        start = content.index(b"\n", len(PLY)) + 1  # after the line of the format
        path.write_bytes(content[:start] + COMMENT + line + content[start:])

    def read(self, path: Path, command: str) -> str:
        """See `Record`."""
        if not path.is_file():
            raise Foreign("it is no file")
        content = path.read_bytes()
        head, found, rest = content.partition(COMMENT)
        line, _, tail = rest.partition(b"\n")
        by, _, digest = line.decode("ascii", "replace").partition(" ")
        if not (content.startswith(PLY) and found and by == command):
            raise Foreign(f"its header names no earlier run of fsel {command}")
        if hashlib.sha256(head + tail).hexdigest() != digest:
            raise Foreign("it was changed since")
        return digest


def _files(folder: Path) -> Iterator[str]:
    """Names below a folder of all that is no folder, links included."""
    for root, folders, files in os.walk(folder):
        links = [name for name in folders if os.path.islink(os.path.join(root, name))]
        for name in (*files, *links):
            yield os.path.relpath(os.path.join(root, name), folder)


def _stamp(path: Path) -> list[int]:
    """Size in bytes and time of change in ns; a digest would read every image."""
    found = path.lstat()
    return [found.st_size, found.st_mtime_ns]
