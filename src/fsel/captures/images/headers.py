"""Headers of image files, read by Pillow: sizes, and refusal of damage, before pixels are decoded.

Decoders take memory for what a header claims: 100 kB may claim gigabytes.
"""

from __future__ import annotations

import os
import struct
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, BinaryIO, cast

from fsel.core.limits import MOST_PIXELS

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile
    from PIL.TiffImagePlugin import TiffImageFile

VARIABLE = "FSEL_MAX_PIXELS"
FORMATS = ("JPEG", "PNG", "BMP", "WEBP", "TIFF")
ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}  # of JPEG and PNG, by their first bytes
TAIL = 1024  # last bytes that hold the end: some cameras write more behind it
WIDTH, HEIGHT = 256, 257  # TIFF's tags
# that Pillow raises for damaged files
FAULTS = (OSError, SyntaxError, ValueError, EOFError, LookupError, TypeError, struct.error)
Size = tuple[int, int]
_lock = Lock()


def shown(path: Path) -> str:
    """A path as it stands; quoted where a character of it would break the line."""
    return str(path) if str(path).isprintable() else repr(str(path))


def check(path: Path) -> Size:
    """(width, height) of an image file, in pixels, without decoding it.

    Damage of pixels is left to the decoder, which takes a hundred times as long.

    Raises:
        ValueError: naming the file, when it is missing, empty, cut short, damaged, of another
            format, or larger than is allowed.
    """
    if not path.is_file():
        raise ValueError(f"{shown(path)}: image file is missing")
    with path.open("rb") as file:
        return size_of(opened(file, path))


def opened(file: BinaryIO, path: Path) -> ImageFile:
    """Pillow's image of a file, of which it has read the header.

    Raises:
        ValueError: naming the file, when it is empty, cut short, damaged in its header, of another
            format, or larger than is allowed.
    """
    start = file.read(2)
    length = file.seek(0, os.SEEK_END)
    if not length:
        raise ValueError(f"{path}: image file is empty (0 bytes)")
    file.seek(max(0, length - TAIL))
    if ENDS.get(start, b"") not in file.read():
        raise ValueError(f"{path}: image file is truncated ({length} bytes)")
    try:
        image = _identified(file)
    except FAULTS as error:
        if isinstance(error, OSError) and error.errno:  # the disk's; Pillow's have no number
            raise
        raise ValueError(
            f"{path}: not a readable image: its {length} bytes are damaged or of another format; "
            f"allowed: {', '.join(FORMATS)}"
        ) from error
    check_size(path, size_of(image))
    return image


def check_size(path: Path, size: Size) -> None:
    """Refuse an image of more pixels than are allowed.

    Raises:
        ValueError: naming the file.
    """
    width, height = size
    if width * height > most_pixels():
        raise ValueError(
            f"{path}: image of {width}x{height} pixels; allowed: {most_pixels():,} pixels in all. "
            f"Hint: the environment variable {VARIABLE} is the bound"
        )


@contextmanager
def without_warnings() -> Iterator[None]:
    """Pillow's warnings are not shown in the block, which one thread at a time enters."""
    with _lock, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _identified(file: BinaryIO) -> ImageFile:
    """Pillow's image, whatever its size: Pillow's own bound is one for all of a process."""
    from PIL import Image  # here: not every command looks at images

    with without_warnings():
        bound, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            return Image.open(file, formats=FORMATS)
        finally:
            Image.MAX_IMAGE_PIXELS = bound


def size_of(image: ImageFile) -> Size:
    """(width, height) of the pixels as they are stored: Pillow's of a TIFF are those shown."""
    if image.format == "TIFF":
        tags = cast("TiffImageFile", image).tag_v2
        return tags[WIDTH], tags[HEIGHT]
    return image.size


def most_pixels() -> int:
    """The greatest number of pixels that an image may have.

    Raises:
        ValueError: when the environment's variable is no positive whole number.
    """
    text = os.environ.get(VARIABLE, str(MOST_PIXELS))
    if not text.isdecimal() or not int(text):
        raise ValueError(f"environment variable {VARIABLE} is {text!r}; allowed: a positive number")
    return int(text)
