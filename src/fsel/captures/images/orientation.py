"""The orientation that an image file asks to be shown in, by its EXIF: read, and taken out."""

from __future__ import annotations

import struct
from io import BytesIO
from pathlib import Path
from typing import BinaryIO
from zlib import crc32

from fsel.captures.images import headers

ORIENTATION = 0x0112  # the tag
UPRIGHT = 1  # its value where pixels are stored as they are to be shown
SHORT, LONG = 3, 4  # TIFF's numbers of two and of four bytes
EXIF = b"Exif\0\0"  # before the block in a JPEG
CHUNK = b"eXIf"  # before the block in a PNG


def of_file(path: Path) -> int:
    """The orientation that an image file states, 1 to 8; 1 where it states none.

    Raises:
        ValueError: see `fsel.captures.images.headers.opened`.
    """
    with path.open("rb") as file:
        return _stated(file, path)[0]


def taken_out(content: bytes, path: Path) -> bytes:
    """A file's content that states orientation 1 where it states one; nothing else changes.

    Raises:
        ValueError: see `fsel.captures.images.headers.opened`.
    """
    value, block = _stated(BytesIO(content), path)
    if value == UPRIGHT:
        return content
    before, after = block, _upright(block, value)
    if CHUNK + block in content:  # a PNG's chunk has a checksum
        before, after = (part + crc32(CHUNK + part).to_bytes(4) for part in (before, after))
    return content.replace(before, after)


def upright_exif(path: Path) -> bytes:
    """The EXIF of a file, for a copy whose pixels are upright; empty where it states no turn.

    Raises:
        ValueError: see `fsel.captures.images.headers.opened`.
    """
    with path.open("rb") as file:
        value, block = _stated(file, path)
    return EXIF + _upright(block, value) if block else b""


def _stated(file: BinaryIO, path: Path) -> tuple[int, bytes]:
    """An orientation, and the block in TIFF's form that states it; empty if none does."""
    from PIL import Image  # here: see `fsel.captures.images.headers`

    image = headers.opened(file, path)
    block = image.info.get("exif", b"").removeprefix(EXIF)
    if image.format == "TIFF":
        file.seek(0)
        block = file.read()
    exif = Image.Exif()
    try:
        with headers.without_warnings():
            exif.load(block)
            value = exif.get(ORIENTATION, UPRIGHT)
    except headers.FAULTS:  # damaged EXIF states none
        return UPRIGHT, b""
    return (value, block) if value in range(1, 9) else (UPRIGHT, b"")


def _upright(block: bytes, value: int) -> bytes:
    """A block in TIFF's form with orientation 1 wherever it states another one."""
    order = "<" if block.startswith(b"II") else ">"
    for form, kind in ((f"{order}HHIH", SHORT), (f"{order}HHII", LONG)):
        entry, upright = (struct.pack(form, ORIENTATION, kind, 1, v) for v in (value, UPRIGHT))
        block = block.replace(entry, upright)
    return block
