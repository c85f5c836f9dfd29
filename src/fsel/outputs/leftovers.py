"""Unfinished outputs beside finished ones: their names, and how those of ended processes go.

`.NAME.HOST.PID.new` is an output that is being written, or an old one that was exchanged for it;
`.NAME.HOST.PID.old` is an old one out of the way, where the file system cannot exchange two names.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fsel.utils.files import host, running

NEW, OLD = "new", "old"


def beside(out: Path, ending: str) -> Path:
    """The name of this process' unfinished output."""
    return out.with_name(f".{out.name}.{host()}.{os.getpid()}.{ending}")


@contextmanager
def held(path: Path) -> Iterator[None]:
    """A lock that other processes, in other containers too, see on the file or folder."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        _locked(descriptor)
        yield
    finally:
        os.close(descriptor)


def clear(out: Path) -> None:
    """Remove what processes of this machine that ended early left beside an output.

    An old output that was out of the way when its process was killed gets its name back.
    """
    pattern = re.compile(rf"\.{re.escape(out.name)}\.{re.escape(host())}\.(\d+)\.({NEW}|{OLD})")
    for path in sorted(out.parent.iterdir()) if out.parent.is_dir() else ():
        found = pattern.fullmatch(path.name)
        if found is None or not _abandoned(path, int(found[1])):
            continue
        if found[2] == OLD and not os.path.lexists(out):
            path.rename(out)
        else:
            remove(path)


def remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _abandoned(path: Path, process: int) -> bool:
    """Whether no such process runs and none holds the lock: a container has numbers of its own."""
    if process != os.getpid() and running(process):
        return False
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        return _locked(descriptor)
    finally:
        os.close(descriptor)


def _locked(descriptor: int) -> bool:
    """Lock an open file or folder; False when another process has locked it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True  # a network's file system without locks: the process' number decides
    return True
