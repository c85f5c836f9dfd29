"""The orientation that an image file asks to be shown in (EXIF): read, taken out, applied."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from pathlib import Path
from struct import error as Short
from struct import pack_into, unpack_from
from zlib import crc32

import numpy as np

from fsel.images.headers import JPEG, PNG, Cut, chunks
from fsel.images.jpeg import Content, segments

ORIENTATION = 0x0112  # the tag
UPRIGHT = 1  # its value where pixels are stored as they are to be shown
EXIF = b"Exif\0\0"  # before the block in a JPEG, and in some WebP files
EXIF_SEGMENT, EXIF_CHUNK = 0xE1, b"eXIf"
FORMS = {3: "H", 4: "I"}  # of TIFF's numbers of two and of four bytes
ORDERS = {b"II*\0": "<", b"MM\0*": ">"}
TURNS = {
    2: lambda image: image[:, ::-1],
    3: lambda image: image[::-1, ::-1],
    4: lambda image: image[::-1],
    5: lambda image: image.swapaxes(0, 1),
    6: lambda image: image[::-1].swapaxes(0, 1),
    7: lambda image: image[::-1, ::-1].swapaxes(0, 1),
    8: lambda image: image.swapaxes(0, 1)[::-1],
}


def of_file(path: Path) -> int:
    """The orientation that an image file states, 1 to 8; 1 where it states none.

    Raises:
        ValueError: for an empty file.
    """
    with (
        path.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        values = [unpack_from(form, content, at)[0] for at, form in _places(content)]
    return next((value for value in values if value in TURNS), UPRIGHT)


def taken_out(content: bytes) -> bytes:
    """A file's content that states orientation 1 where it states one; nothing else changes."""
    places = _places(content)
    if not places:
        return content
    found = bytearray(content)
    for at, form in places:
        pack_into(form, found, at, UPRIGHT)
    if content.startswith(PNG):
        for kind, start, end in chunks(content):
            if kind == EXIF_CHUNK:
                pack_into(">I", found, end, crc32(found[start - 4 : end]))
    return bytes(found)


def applied(image: np.ndarray, orientation: int) -> np.ndarray:
    """(h, w, 3) or (w, h, 3): the (h, w, 3) stored pixels as an orientation wants them shown."""
    return TURNS[orientation](image) if orientation in TURNS else image


def with_exif(encoded: bytes, original: bytes) -> bytes:
    """A JPEG with the EXIF of the JPEG that it was made of, if any, which states orientation 1.

    COLMAP guesses focal lengths by it.
    """
    kept = taken_out(original)
    parts = [
        kept[start:end]
        for marker, start, end in (segments(kept) if kept.startswith(JPEG) else ())
        if marker == EXIF_SEGMENT and kept.startswith(EXIF, start + 4)
    ]
    return b"".join([encoded[:2], *parts, encoded[2:]])


def _places(content: Content) -> list[tuple[int, str]]:
    """Where orientations stand, and in what form; what is damaged states none."""
    try:
        return [place for start in _blocks(content) for place in _in_block(content, start)]
    except (Cut, Short, IndexError):
        return []


def _blocks(content: Content) -> Iterator[int]:
    """Where blocks in TIFF's form begin that say how the image is to be shown."""
    if content[:4] in ORDERS:
        yield 0
    elif content[: len(JPEG)] == JPEG:
        for marker, start, _ in segments(content):
            if marker == EXIF_SEGMENT and content[start + 4 : start + 4 + len(EXIF)] == EXIF:
                yield start + 4 + len(EXIF)
    elif content[: len(PNG)] == PNG:
        yield from (start for kind, start, _ in chunks(content) if kind == EXIF_CHUNK)
    elif content[:4] == b"RIFF":
        at = 12
        while at + 8 <= len(content):
            kind, length = unpack_from("<4sI", content, at)
            if kind == b"EXIF":
                named = content[at + 8 : at + 8 + len(EXIF)] == EXIF
                yield at + 8 + named * len(EXIF)
            at += 8 + length + length % 2


def _in_block(content: Content, block: int) -> Iterator[tuple[int, str]]:
    """The orientations of a block's first image."""
    order = ORDERS.get(content[block : block + 4])
    if order is None:
        return
    at = block + unpack_from(f"{order}I", content, block + 4)[0]
    (count,) = unpack_from(f"{order}H", content, at)
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind = unpack_from(f"{order}HH", content, entry)
        if tag == ORIENTATION and kind in FORMS:
            yield entry + 8, order + FORMS[kind]
