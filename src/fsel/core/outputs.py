"""Outputs that appear whole or not at all, and replace nothing but what the same command wrote.

A folder holds `manifest.json`: the command, and every file's size and time of change. A `.ply`, a
page or an `.mp4` holds a comment: the command, and a digest of the rest of the file. Nothing
without such a record is ever replaced.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from fsel.core.files import unfinished

MANIFEST = "manifest.json"
SPACE = 94  # bytes that a record takes in the box of an .mp4


class Comment(NamedTuple):
    """A place of a file's format that other programs pass over.

    Attributes:
        head: of files that have it, from the byte `at` on.
        before, after: what encloses it.
        last: it ends the file; else it follows the first line after the head.
    """

    head: bytes
    before: bytes
    after: bytes
    at: int = 0
    last: bool = False

    def place(self, content: bytes) -> int:
        """Byte at which it begins."""
        return len(content) if self.last else content.index(b"\n", len(self.head)) + 1


COMMENTS = (
    Comment(b"ply\n", b"comment fsel ", b"\n"),
    Comment(b"<!doctype html>", b"<!-- fsel ", b" -->\n"),
    # a box `free` of ISO/IEC 14496-12: its size, its name, its content
    Comment(b"ftyp", (14 + SPACE).to_bytes(4, "big") + b"freefsel ", b"\n", at=4, last=True),
)


class Foreign(Exception):
    """Reason why an output is not what a run of the command left behind."""


@contextmanager
def staged(
    out: Path, command: str, inputs: Iterable[Path], force: bool, *, folder: bool = True
) -> Iterator[Path]:
    """A folder or file beside `out` that takes its name when the block ends without errors.

    It is there, empty, when the block begins: where nothing can be written, that is refused before
    work. A symbolic link is followed. An old output is moved aside for a moment; one that a killed
    process left there gets its name back at the next run.

    Args:
        out: the output to be; its parents are made.
        command: that writes it.
        inputs: files and folders that the command reads.
        force: replace what an earlier run of the command wrote, if it is unchanged.
        folder: whether the output is a folder.

    Raises:
        FileExistsError: when `out` exists, at the start or at the end, and may not be replaced:
            without `force`, or when it is not just as a run of the command left it.
        ValueError: when `out` is, holds or lies in an input.
    """
    named, out = out, Path(os.path.realpath(out))
    refuse_overlap(named, inputs)
    old = out.with_name(f".{out.name}.old")
    if os.path.lexists(old) and not os.path.lexists(out):
        old.rename(out)
    earlier = _replaced(named, out, command, force)
    missing = [parent for parent in out.parents if not parent.exists()]
    stage = unfinished(out)
    try:
        _remove(stage)
        stage.mkdir() if folder else stage.touch()
        yield stage
        _record(stage, command)
        if _now(out, command) != earlier:
            raise FileExistsError(
                f"{named}: was made or changed by somebody else while this command ran, and is "
                "left as it is. Hint: run it again, or give another place"
            )
        _rename(stage, out, old)
    finally:
        _remove(stage)
        for parent in missing:
            if parent.is_dir() and not any(parent.iterdir()):
                parent.rmdir()


def refuse_overlap(out: Path, inputs: Iterable[Path]) -> None:
    """Refuse an output that is, holds or lies in what is read, whatever links lead there.

    Raises:
        ValueError: naming both.
    """
    place = Path(os.path.realpath(out))
    for path in inputs:
        source = Path(os.path.realpath(path))
        if place.is_relative_to(source) or source.is_relative_to(place):
            raise ValueError(
                f"{out}: an output may not be, hold or lie in what is read, {path}. "
                "Hint: give another place"
            )


def _replaced(named: Path, out: Path, command: str, force: bool) -> str:
    """The record of an output that shall be replaced; empty where nothing is."""
    if not _taken(out):
        return ""
    if not force:
        raise FileExistsError(f"{named}: exists already. Hint: --force replaces it")
    try:
        return _recorded(out, command)
    except Foreign as reason:
        raise FileExistsError(
            f"{named}: --force does not replace it, since {reason}; only what an earlier run of "
            f"fsel {command} wrote is replaced. Hint: give another place, or remove it yourself"
        ) from reason


def _now(out: Path, command: str) -> str | None:
    """The record of an output; empty where nothing is, None of what the command did not leave."""
    try:
        return _recorded(out, command) if _taken(out) else ""
    except Foreign:
        return None


def _taken(out: Path) -> bool:
    return os.path.lexists(out) and not (out.is_dir() and not any(out.iterdir()))


def _rename(stage: Path, out: Path, old: Path) -> None:
    """Give a finished output its name."""
    if out.is_dir() and any(out.iterdir()):
        _remove(old)
        out.rename(old)
    elif out.is_dir():
        out.rmdir()
    try:
        stage.replace(out)
    except BaseException:
        if old.exists() and not out.exists():
            old.rename(out)
        raise
    _remove(old)


def _remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _record(path: Path, command: str) -> None:
    """Write the record of a finished output into it."""
    if path.is_dir():
        files = {name: _stamp(path / name) for name in _files(path)}
        manifest = {"command": f"fsel {command}", "files": dict(sorted(files.items()))}
        (path / MANIFEST).write_text(json.dumps(manifest, indent=1), encoding="utf-8")
        return
    content = path.read_bytes()
    comment = _comment_of(content)
    if comment is None:
        raise ValueError(f"{path}: expected a .ply, a page or an .mp4 to record")
    line = f"{command} {hashlib.sha256(content).hexdigest()}".encode()
    start = comment.place(content)
    record = comment.before + (line.ljust(SPACE) if comment.last else line) + comment.after
    path.write_bytes(content[:start] + record + content[start:])


def _comment_of(content: bytes) -> Comment | None:
    """The place for a record in such a file; None of another."""
    return next((one for one in COMMENTS if content.startswith(one.head, one.at)), None)


def _recorded(path: Path, command: str) -> str:
    """The record in an output, which tells it from those of the command's other runs.

    Raises:
        Foreign: when it is no output of the command, or was changed since.
    """
    return _of_folder(path, command) if path.is_dir() else _of_file(path, command)


def _of_folder(path: Path, command: str) -> str:
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


def _of_file(path: Path, command: str) -> str:
    content = path.read_bytes() if path.is_file() else b""
    comment = _comment_of(content)
    if comment is None:
        raise Foreign(f"it names no earlier run of fsel {command}")
    head, found, rest = content.partition(comment.before)
    line, _, tail = rest.partition(comment.after)
    by, _, digest = line.decode("ascii", "replace").strip().partition(" ")
    if not (found and by == command):
        raise Foreign(f"it names no earlier run of fsel {command}")
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
    stat = path.lstat()
    return [stat.st_size, stat.st_mtime_ns]
