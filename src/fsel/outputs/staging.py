"""Outputs that appear whole or not at all, and replace nothing but what the same command wrote."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fsel.outputs import leftovers
from fsel.outputs.records import Foreign, Record
from fsel.outputs.renames import exchange, rename_new


@contextmanager
def staged(
    out: Path, command: str, record: Record, inputs: Iterable[Path], force: bool
) -> Iterator[Path]:
    """A file or folder beside `out` that takes its name when the block ends without an error.

    What processes that ended early left beside `out` is cleared first. A symbolic link is followed.

    Args:
        out: the output to be; its parents are made.
        command: that writes it.
        record: how such an output is recorded.
        inputs: files and folders that the command reads.
        force: replace what an earlier run of the command wrote, if it is unchanged.

    Raises:
        FileExistsError: when `out` exists, at the start or at the end, and may not be replaced:
            without `force`, or when it is not just as a run of the command left it.
        ValueError: when `out` is, holds or lies in an input.
    """
    named, out = out, Path(os.path.realpath(out))
    refuse_overlap(named, inputs)
    leftovers.clear(out)
    earlier = _replaced(named, out, command, record, force)
    made = _make_parents(out)
    stage = leftovers.beside(out, leftovers.NEW)
    try:
        record.begin(stage)
        with leftovers.held(stage):
            yield stage
            record.write(stage, command)
            if earlier is None:
                rename_new(stage, out)
            else:
                _replace(stage, out, command, record, earlier)
    finally:
        leftovers.remove(stage)
        for folder in made:
            if not os.path.lexists(out) and folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()


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


def _replaced(named: Path, out: Path, command: str, record: Record, force: bool) -> str | None:
    """The record of an output that shall be replaced; None where there is nothing."""
    if not os.path.lexists(out) or (out.is_dir() and not any(out.iterdir())):
        return None
    if not force:
        raise FileExistsError(f"{named}: exists already. Hint: --force replaces it")
    try:
        return record.read(out, command)
    except Foreign as reason:
        raise FileExistsError(
            f"{named}: --force does not replace it, since {reason}; only what an earlier run of "
            f"fsel {command} wrote is replaced. Hint: give another place, or remove it yourself"
        ) from reason


def _replace(stage: Path, out: Path, command: str, record: Record, earlier: str) -> None:
    """Take the place of an earlier output, unless it was changed while this one was made."""
    if not os.path.lexists(out):
        rename_new(stage, out)
        return
    old = stage
    if not exchange(stage, out):
        old = leftovers.beside(out, leftovers.OLD)
        out.rename(old)
        _name_or_restore(stage, out, old)
    if _same(old, command, record, earlier):
        leftovers.remove(old)
        return
    if old == stage:
        exchange(stage, out)
    else:
        out.rename(stage)
        old.rename(out)
    raise FileExistsError(
        f"{out}: was changed while this command ran, and is left as it is. Hint: run it again"
    )


def _name_or_restore(stage: Path, out: Path, old: Path) -> None:
    try:
        rename_new(stage, out)
    except BaseException:
        if not os.path.lexists(out):
            old.rename(out)
        raise


def _same(path: Path, command: str, record: Record, earlier: str) -> bool:
    try:
        return record.read(path, command) == earlier
    except Foreign:
        return False


def _make_parents(out: Path) -> list[Path]:
    """Make the folders above an output; those that were missing, the innermost first."""
    missing = [folder for folder in out.parents if not os.path.lexists(folder)]
    out.parent.mkdir(parents=True, exist_ok=True)
    return missing
