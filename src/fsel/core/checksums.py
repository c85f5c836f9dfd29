"""Checksums beside artefacts: whether a file still is what the job wrote that made it.

The checksum of `images.npy` is `.images.npy.sha256`, in the format of `sha256sum`, which can check
it too. A file without one is not checked.
"""

from __future__ import annotations

import hashlib
import os
import shlex
from collections.abc import Iterable
from pathlib import Path

from fsel.core.files import write_text

ALWAYS = 16 << 20  # bytes of a file that is read through at every check


class Damaged(ValueError):
    """A file is not what its checksum says.

    Attributes:
        fault: the file, and what is wrong with it.
    """

    def __init__(self, fault: str, path: Path) -> None:
        super().__init__(f"{fault}. {remade([path])}")
        self.fault = fault


def beside(path: str | Path) -> Path:
    """Path of a file's checksum."""
    path = Path(path)
    return path.with_name(f".{path.name}.sha256")


def write(path: str | Path) -> None:
    """Write the checksum of a finished file; a folder has none."""
    path = Path(path)
    if path.is_file():
        text = f"# {path.stat().st_size} bytes\n{sha256_of(path)}  {path.name}\n"
        write_text(text, beside(path))


def check(path: str | Path) -> None:
    """Compare a file with its checksum, if there is one.

    A file of more than 16 MiB is read through only if the file system changed anything of it since
    the last time: its change time, which nothing can set back, is later than its checksum's time.
    What a disk loses in silence is seen in smaller files alone.

    Raises:
        Damaged: when the length or the bytes differ, naming the file and what makes it anew.
    """
    path, record = Path(path), beside(path)
    try:
        stated = record.read_text(encoding="utf-8").split()
        size, wanted = int(stated[1]), stated[3]
        known = record.stat().st_mtime_ns
    except FileNotFoundError:
        return
    except (ValueError, IndexError) as error:
        raise Damaged(f"{record}: not a checksum", path) from error
    stat = path.stat()
    if stat.st_size != size:
        fault = f"{path}: has {stat.st_size} bytes, and had {size} when it was made"
        raise Damaged(fault, path)
    if size > ALWAYS and stat.st_ctime_ns <= known:
        return
    if sha256_of(path) != wanted:
        raise Damaged(f"{path}: its bytes are not those that were made", path)
    if size > ALWAYS:
        os.utime(record)


def damages(paths: Iterable[str | Path]) -> dict[Path, str]:
    """Damaged file -> what is wrong with it, of the files that are there."""
    faults = {}
    for path in sorted(set(map(Path, paths))):
        try:
            if path.is_file():
                check(path)
        except Damaged as error:
            faults[path] = error.fault
    return faults


def remade(paths: Iterable[Path]) -> str:
    """Sentence that says what makes files anew."""
    names = " ".join(shlex.quote(str(path)) for path in paths)
    return f"Make it anew, with the options of this run: snakemake --cores 1 --force {names}"


def sha256_of(path: Path) -> str:
    """Digest of a file, as `sha256sum` writes it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
