"""What an image file says before its pixels are decoded: its size, and whether it is whole.

Decoders take memory for what a header claims: 100 kB may claim gigabytes.
"""

from __future__ import annotations

import mmap
import os
from collections.abc import Callable
from pathlib import Path
from struct import error as Short
from struct import unpack_from
from zlib import crc32

from fsel.images.jpeg import FRAMES, Content, segments, tables_hold
from fsel.utils.limits import MOST_PIXELS

VARIABLE = "FSEL_MAX_PIXELS"
PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"  # by which decoders know them
FORMATS = "PNG, JPEG, WebP, BMP, TIFF"
TAIL = 1024  # last bytes of a JPEG that hold its end: some cameras write more behind it
WIDTH, HEIGHT = 256, 257  # TIFF's tags
SHORT = 3  # TIFF's type of numbers of two bytes
Size = tuple[int, int]


class Cut(Exception):
    """A file ends before its format does."""


def shown(path: Path) -> str:
    """A path as it stands; quoted where a character of it would break the line."""
    return str(path) if str(path).isprintable() else repr(str(path))


def check(path: Path) -> Size:
    """(width, height) of an image file, in pixels, without decoding it.

    Damage in the pixels of a JPEG is not seen: decoders too go on after it.

    Raises:
        ValueError: naming the file, when it is missing, empty, cut short, damaged, of another
            format, or larger than is allowed.
    """
    if not path.is_file():
        raise ValueError(f"{shown(path)}: image file is missing")
    with path.open("rb") as file:
        if not os.fstat(file.fileno()).st_size:
            raise ValueError(f"{path}: image file is empty (0 bytes)")
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            size = size_of(content, path)
            _check_damage(content, path)
    return size


def size_of(content: Content, path: Path) -> Size:
    """(width, height) that an image file states.

    Raises:
        ValueError: see `check`; damage is not looked for.
    """
    read = _reader(content[:12])
    try:
        width, height = read(content) if read else (0, 0)
    except (Cut, Short, IndexError):
        raise ValueError(f"{path}: image file is truncated ({len(content)} bytes)") from None
    if not (width and height):
        raise ValueError(f"{path}: not a readable image ({len(content)} bytes); allowed: {FORMATS}")
    most = most_pixels()
    if width * height > most:
        raise ValueError(
            f"{path}: image of {width}x{height} pixels; allowed: {most:,} pixels in all. "
            f"Hint: the environment variable {VARIABLE} is the bound"
        )
    return width, height


def most_pixels() -> int:
    """The greatest number of pixels that an image may have.

    Raises:
        ValueError: when the environment's variable is no positive whole number.
    """
    text = os.environ.get(VARIABLE, str(MOST_PIXELS))
    if not text.isdecimal() or not int(text):
        raise ValueError(f"environment variable {VARIABLE} is {text!r}; allowed: a positive number")
    return int(text)


def _reader(start: bytes) -> Callable[[Content], Size] | None:
    if start.startswith(PNG):
        return _png
    if start.startswith(JPEG):
        return _jpeg
    if start[:4] == b"RIFF" and start[8:12] == b"WEBP":
        return _webp
    if start.startswith(b"BM"):
        return _bmp
    return _tiff if start[:4] in (b"II*\0", b"MM\0*") else None


def _png(content: Content) -> Size:
    kind, *_ = kinds = [kind for kind, _, _ in chunks(content)]
    if kind != b"IHDR":
        return 0, 0
    if kinds[-1] != b"IEND":
        raise Cut
    width, height = unpack_from(">II", content, 16)
    return width, height


def chunks(content: Content) -> list[tuple[bytes, int, int]]:
    """Kind of each of a PNG's chunks, where its content starts and where that ends.

    Raises:
        Cut: when the file ends before the last.
    """
    found, at = [], len(PNG)
    while True:
        length, kind = unpack_from(">I4s", content, at)
        end = at + 8 + length
        if end + 4 > len(content):
            raise Cut
        found.append((kind, at + 8, end))
        if kind == b"IEND":
            return found
        at = end + 4


def _jpeg(content: Content) -> Size:
    if b"\xff\xd9" not in content[-TAIL:]:
        raise Cut
    for marker, at, _ in segments(content):
        if marker in FRAMES:
            height, width = unpack_from(">HH", content, at + 5)
            return width, height
    return 0, 0


def _webp(content: Content) -> Size:
    kind = content[12:16]
    if kind == b"VP8X":
        low = [int.from_bytes(content[at : at + 3], "little") + 1 for at in (24, 27)]
        return low[0], low[1]
    if kind == b"VP8L":
        (bits,) = unpack_from("<I", content, 21)
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    width, height = unpack_from("<HH", content, 26)
    return width & 0x3FFF, height & 0x3FFF


def _bmp(content: Content) -> Size:
    (header,) = unpack_from("<I", content, 14)
    width, height = unpack_from("<HH" if header == 12 else "<ii", content, 18)
    return abs(width), abs(height)


def _tiff(content: Content) -> Size:
    order = "<" if content[:2] == b"II" else ">"
    (at,) = unpack_from(f"{order}I", content, 4)
    (count,) = unpack_from(f"{order}H", content, at)
    found = {WIDTH: 0, HEIGHT: 0}
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind = unpack_from(f"{order}HH", content, entry)
        if tag in found:
            (found[tag],) = unpack_from(
                f"{order}{'H' if kind == SHORT else 'I'}", content, entry + 8
            )
    return found[WIDTH], found[HEIGHT]


def _check_damage(content: Content, path: Path) -> None:
    """Refuse what a decoder would refuse, at a small part of its time."""
    if content[: len(PNG)] == PNG:
        for kind, start, end in chunks(content):
            (stated,) = unpack_from(">I", content, end)
            if crc32(content[start - 4 : end]) != stated:
                raise ValueError(f"{path}: not a readable image: its {kind!r} chunk is damaged")
    if content[: len(JPEG)] == JPEG and not tables_hold(content):
        raise ValueError(f"{path}: not a readable image: its header is damaged")
