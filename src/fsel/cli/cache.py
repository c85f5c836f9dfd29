"""`fsel cache`: list what is kept in the user's cache folder, and clear it."""

from __future__ import annotations

import argparse
import re
import shutil
from pathlib import Path

from fsel.captures.parsing import read_json
from fsel.captures.poses.kept import FOUND, LOCK, locked
from fsel.cli.console import Console
from fsel.core.files import cache

OURS = re.compile(r"[0-9a-f]{16}|compiled|(aliked|lpips|viewer|xfeat)[-_.].+")
"""Names of what is kept: FSEL_CACHE may name a folder that holds more."""


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    folder, entries, total = cache(), [], 0
    inside = folder.iterdir() if folder.is_dir() else ()
    for path in sorted(path for path in inside if OURS.fullmatch(path.name)):
        files = [path, *([] if path.is_symlink() else path.rglob("*"))]
        size = sum(file.lstat().st_size for file in files)  # of links, not of what they lead to
        entries.append({"name": path.name, "bytes": size, "of": _source(path)})
        console.say(f"{size / 1e6:.1f} MB", f"{path.name}  {entries[-1]['of']}")
        total += size
        if args.clear:
            _remove(path, console)
    said = "cleared" if args.clear else "fsel cache --clear empties it"
    console.say("cache", f"{folder}: {total / 1e6:.1f} MB; {said}")
    console.give({"folder": str(folder), "entries": entries})


def _source(path: Path) -> str:
    """Say what an entry is, where its name does not."""
    if (path / FOUND).is_file():
        try:
            return f"poses of {', '.join(read_json(path / FOUND)['sources'])}"
        except (ValueError, KeyError, TypeError):
            return "poses, damaged"
    return "poses, unfinished" if (path / LOCK).is_file() else ""


def _remove(path: Path, console: Console) -> None:
    """Remove an entry, unless another process is at work in it."""
    if path.is_symlink() or not path.is_dir():
        path.unlink()
        return
    try:
        with locked(path / LOCK, seconds=0):
            shutil.rmtree(path)
    except TimeoutError:
        console.warn(f"{path}: is in use and is kept")
    except OSError:  # no lock can be made there, as on a full disk
        shutil.rmtree(path)
