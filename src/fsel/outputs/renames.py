"""Renames that the system carries out in one step, or refuses."""

from __future__ import annotations

import ctypes
import errno
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

AT_FDCWD = -100  # paths are relative to the working folder
NO_REPLACE, EXCHANGE = 1, 2  # flags of Linux' renameat2(2)
TAKEN = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR, errno.EISDIR)
LACKING = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM)


def rename_new(source: Path, target: Path) -> None:
    """Rename a file or folder where nothing is, or a folder over an empty one.

    Raises:
        FileExistsError: when anything else has the name; it stays as it is.
    """
    try:
        if source.is_dir():
            source.rename(target)  # POSIX: replaces an empty folder and nothing else
        elif not _renameat2(source, target, NO_REPLACE):
            os.link(source, target)
            source.unlink()
    except OSError as error:
        if error.errno not in TAKEN:
            raise
        raise FileExistsError(
            f"{target}: was made by somebody else while this command ran, and is left as it is"
        ) from error


def exchange(one: Path, other: Path) -> bool:
    """Let two files or folders exchange their names; False where the file system cannot."""
    return _renameat2(one, other, EXCHANGE)


def _renameat2(source: Path, target: Path, flag: int) -> bool:
    """Whether the system and the file system know the flag; errors of other kinds are raised."""
    call = _call()
    if call is None:
        return False
    if call(AT_FDCWD, os.fsencode(source), AT_FDCWD, os.fsencode(target), flag) == 0:
        return True
    number = ctypes.get_errno()
    if number in LACKING:
        return False
    raise OSError(number, os.strerror(number), str(target))


@cache
def _call() -> Callable[..., int] | None:
    """The C library's function; None where it has none."""
    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is not None:
        place = (ctypes.c_int, ctypes.c_char_p)
        call.argtypes = (*place, *place, ctypes.c_uint)
    return call
