"""Outputs of commands, which appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fsel.core.files import unfinished


@contextmanager
def staged(
    out: Path, inputs: Iterable[Path], force: bool, *, folder: bool = True
) -> Iterator[Path]:
    """Make a temporary folder or file beside `out`, renamed to it when the block ends.

    It is there, empty, when the block begins, so that a place where nothing can be written is
    refused before work. A symbolic link is followed.

    Args:
        out: the output to be; its parents are made.
        inputs: files and folders that the command reads.
        force: replace what is there.
        folder: whether the output is a folder.

    Raises:
        FileExistsError: when `out` exists, at the start or at the end, and not `force`.
        ValueError: when `out` is, holds or lies in an input, whatever links lead there.
    """
    place = Path(os.path.realpath(out))
    for path in inputs:
        source = Path(os.path.realpath(path))
        if place.is_relative_to(source) or source.is_relative_to(place):
            raise ValueError(
                f"{out}: the output must not be, contain or lie inside an input, {path}. "
                "Hint: give another place"
            )
    _refuse_existing(out, force)
    stage = unfinished(place)
    _remove(stage)
    try:
        stage.mkdir() if folder else stage.touch()
        yield stage
        _refuse_existing(out, force)
        _rename(stage, place)
    finally:
        _remove(stage)


def _refuse_existing(out: Path, force: bool) -> None:
    """Refuse to replace what is there without `force`, and a home or working folder ever."""
    place = Path(os.path.realpath(out))
    if not os.path.lexists(place) or (place.is_dir() and not any(place.iterdir())):
        return
    if not force:
        raise FileExistsError(f"{out}: exists already. Hint: `force=True` (--force) replaces it")
    if any(own.is_relative_to(place) for own in (Path.cwd(), Path.home())):
        raise FileExistsError(f"{out}: contains your home or working folder. Hint: another place")


def _rename(stage: Path, out: Path) -> None:
    """Give a finished output its name; a folder there is moved aside until it has it."""
    old = out.with_name(f".{out.name}.old")
    _remove(old)
    if out.is_dir():
        out.rename(old)
    try:
        stage.replace(out)
    except BaseException:
        if old.exists():
            old.rename(out)
        raise
    _remove(old)


def _remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
