"""One scene out of an archive that is not trusted."""

from __future__ import annotations

import errno
import hashlib
import logging
import lzma
import shutil
import stat
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from fsel.core.files import File
from fsel.core.outputs import staged

MOST = 20.0  # GB of a scene
BROKEN = (  # what damage comes out as: of the archive, of a member by its compression, of a name
    *(zipfile.BadZipFile, struct.error, EOFError, OSError, RuntimeError, OverflowError),
    *(zlib.error, lzma.LZMAError, UnicodeDecodeError),
)
logger = logging.getLogger(__name__)


def unpack(
    archive: File,
    inside: str,
    folder: File,
    *,
    files: Mapping[str, str] | None = None,
    licence: str = "",
    most: float = MOST,
) -> None:
    """Unpack one folder of a zip archive, and the archives that lie in it, whole or not at all.

    Args:
        archive: not trusted: members that are links, or lead out of the target, are refused before
            anything is written.
        folder: what it becomes; replaced if an earlier run unpacked it.
        files: of the folder -> their sha256.
        licence: of what is in it, for the log.
        most: GB that its files may take, with those of the archives in it.

    Raises:
        ValueError: for a broken or unsafe archive, one without that folder, a larger one, or a file
            that is not there or has another sha256.
    """
    archive = Path(archive)
    with staged(Path(folder), [archive], force=True) as partial:
        left = most - _extract(archive, inside, partial, most)
        for inner in sorted(partial.glob("*.zip")):
            left -= _extract(inner, "", partial, left)
            inner.unlink()
        for name, wanted in (files or {}).items():
            _check_file(archive, partial / name, name, wanted)
    logger.info("%s: licence: %s", folder, licence or "see the page of its owners")


def _check_file(archive: Path, path: Path, name: str, wanted: str) -> None:
    digest = "that of no file"
    if path.is_file():
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    if digest != wanted:
        raise ValueError(
            f"{archive}: sha256 of {name} is {digest}, expected {wanted}. Hint: delete the archive "
            "and fetch it again; if it stays so, the file was replaced at its source"
        )


def _extract(archive: Path, inside: str, folder: Path, most: float) -> float:
    """Extract a folder of an archive, and return how many GB it has."""
    try:
        with zipfile.ZipFile(archive) as content:
            root = PurePosixPath(inside)
            members = [m for m in content.infolist() if root in PurePosixPath(m.filename).parents]
            if not members:
                tops = sorted({m.filename.split("/")[0] for m in content.infolist()})
                raise ValueError(f"{archive}: no folder {inside!r} in it, only {tops[:8]}")
            for member in content.infolist():
                _check_member(archive, member)
            size = sum(member.file_size for member in members) / 1e9  # no more is read of any
            if size > most:
                raise ValueError(
                    f"{archive}: unpacks to {size:.3g} GB; allowed: {most:.3g}. Hint: `most_gb` of "
                    "the scene, in config/sources.yaml"
                )
            for member in members:
                target = folder / PurePosixPath(member.filename).relative_to(inside)
                if member.is_dir():
                    target.mkdir(parents=True, exist_ok=True)
                    continue
                target.parent.mkdir(parents=True, exist_ok=True)
                with content.open(member) as source, target.open("wb") as file:
                    shutil.copyfileobj(source, file)
            return size
    except BROKEN as error:
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise ValueError(
            f"{archive}: cannot be unpacked ({error}). Hint: delete it and fetch it again"
        ) from error


def _check_member(archive: Path, member: zipfile.ZipInfo) -> None:
    path, mode = PurePosixPath(member.filename), member.external_attr >> 16
    if path.is_absolute() or ".." in path.parts or set("\\:") & set(member.filename):
        raise ValueError(f"{archive}: member {member.filename!r} leads out of the folder; refused")
    if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise ValueError(f"{archive}: member {member.filename!r} is a link or device; refused")
