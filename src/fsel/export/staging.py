"""Folders that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def staged(out: Path, written: Collection[str], force: bool) -> Iterator[Path]:
    """A folder beside `out` that takes its name when the block ends without an error.

    Args:
        out: the folder to be; its parents are made.
        written: every name that may be in it; the first is always there.
        force: replace what an earlier run wrote.

    Raises:
        FileExistsError: when `out` exists and may not be replaced: without `force`, or when it
            holds anything that an earlier run cannot have written. Nothing that a person made is
            ever deleted.
    """
    _refuse_existing(out, written, force)
    out.parent.mkdir(parents=True, exist_ok=True)
    stage, old = (out.parent / f".{out.name}.{os.getpid()}.{end}" for end in ("new", "old"))
    stage.mkdir()
    try:
        yield stage
        if out.exists():
            out.rename(old)
        stage.rename(out)
    finally:
        shutil.rmtree(stage, ignore_errors=True)
        if old.exists() and not out.exists():
            old.rename(out)
        shutil.rmtree(old, ignore_errors=True)


def _refuse_existing(out: Path, written: Collection[str], force: bool) -> None:
    if out.is_dir() and not any(out.iterdir()):
        return
    if not out.exists() and not out.is_symlink():
        return
    if not force:
        raise FileExistsError(f"{out}: exists already. Hint: --force replaces it")
    first, *_ = written
    foreign = sorted({entry.name for entry in out.iterdir()} - {*written}) if out.is_dir() else []
    if foreign or not (out / first).is_file():
        what = f"it holds {foreign[0]!r}" if foreign else f"it holds no {first}"
        raise FileExistsError(
            f"{out}: --force does not replace it, since {what}, unlike anything that this command "
            "writes. Hint: give another folder, or empty this one yourself"
        )
