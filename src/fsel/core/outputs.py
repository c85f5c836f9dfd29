"""Outputs of commands, which appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fsel.core.files import unfinished
from fsel.core.names import check_utf8

LISTED = ".fsel"  # file of a folder that names all others that were written with it
SYSTEMS = (".DS_Store", "Thumbs.db", "desktop.ini")  # what file managers put into any folder


@contextmanager
def staged(
    out: Path, inputs: Iterable[Path], force: bool, *, folder: bool = True
) -> Iterator[Path]:
    """Make a temporary folder or file beside `out`, renamed to it when the block ends.

    It is there, empty, when the block begins, so that a place where nothing can be written is
    refused before work. A symbolic link is followed. A folder lists what was written, and one that
    has anything else in it is never replaced.

    Args:
        out: the output to be; its parents are made.
        inputs: files and folders that the command reads.
        force: replace what is there.
        folder: whether the output is a folder.

    Raises:
        FileExistsError: when `out` exists, at the start or at the end, and not `force`, or it was
            not written here.
        ValueError: when `out` is, holds or lies in an input, whatever links lead there, or a name
            is not UTF-8.
    """
    place = Path(os.path.realpath(out))
    check_utf8(place)
    for path in inputs:
        source = Path(os.path.realpath(path))
        check_utf8(source)
        if place.is_relative_to(source) or source.is_relative_to(place):
            raise ValueError(
                f"{out}: the output must not be, contain or lie inside an input, {path}. "
                "Hint: give another place"
            )
    _refuse_existing(out, force, folder)
    own = unfinished(place)
    shutil.rmtree(own, ignore_errors=True)
    stage = own / place.name
    try:
        own.mkdir()
    except OSError as error:  # of a read-only disk, by the name that a person knows
        raise OSError(error.errno, error.strerror, str(out)) from error
    try:
        stage.mkdir() if folder else stage.touch()
        yield stage
        if folder:
            names = sorted(path.relative_to(stage).as_posix() for path in _files(stage))
            (stage / LISTED).write_text("\n".join(names), encoding="utf-8")
        _refuse_existing(out, force, folder)
        _rename(stage, place, own / "replaced")
    finally:
        shutil.rmtree(own, ignore_errors=True)


def _refuse_existing(out: Path, force: bool, folder: bool) -> None:
    """Refuse to replace what is there without `force`, and what was not written here ever."""
    place = Path(os.path.realpath(out))
    if place.is_mount():
        raise FileExistsError(f"{out}: is a mount point. Hint: {out}/NAME")
    if not os.path.lexists(place) or (place.is_dir() and not any(place.iterdir())):
        return
    if not force:
        raise FileExistsError(f"{out}: exists already. Hint: `force=True` replaces it")
    if any(own.is_relative_to(place) for own in (Path.cwd(), Path.home())):
        raise FileExistsError(f"{out}: contains your home or working folder. Hint: another place")
    if folder and not place.is_dir():
        raise FileExistsError(f"{out}: is a file; a folder is written. Hint: another place")
    if strange := next(_strange(place), None):
        raise FileExistsError(
            f"{out}: is not replaced, for {strange.relative_to(place)} in it is none of the files "
            f"that fsel listed in {LISTED}. Hint: give another place, or move it away"
        )


def _strange(place: Path) -> Iterator[Path]:
    """Yield the files in a folder that no output listed, of which there are none in an output."""
    listed, known = place / LISTED, {place / LISTED}
    if listed.is_file():
        known |= {place / line for line in listed.read_text("utf-8", "replace").split("\n")}
    return (path for path in _files(place) if path not in known and path.name not in SYSTEMS)


def _files(folder: Path) -> Iterator[Path]:
    """Yield all in a folder but its folders; links to folders are not entered."""
    return (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())


def _rename(stage: Path, out: Path, replaced: Path) -> None:
    """Give a finished output its name; a folder there is moved aside until it has it."""
    if out.is_dir():
        out.rename(replaced)
    try:
        stage.replace(out)
    except BaseException:
        if replaced.exists():
            replaced.rename(out)
        raise
