"""Photos as phones keep them, HEIC, read by pillow-heif where it is installed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from fsel.captures.images import headers

if TYPE_CHECKING:
    from PIL.Image import Image

ENDINGS = (".heic", ".heif")
EXTRA = "pip install 'fsel[heic]'"


def is_heic(path: Path) -> bool:
    """Check whether a path has the ending of such a photo."""
    return path.suffix.lower() in ENDINGS


def readable() -> bool:
    """Check whether the package that reads them is installed."""
    return find_spec("pillow_heif") is not None


def load(file: Path) -> Image:
    """A photo in RGB, upright as it is to be shown, with its EXIF, which then asks for no turn.

    Raises:
        ValueError: for a file that cannot be read, or is larger than is allowed, named.
    """
    import pillow_heif  # here: an extra

    with _named(file):
        photo = pillow_heif.open_heif(file)
    headers.check_size(file, photo.size)
    with _named(file):
        return photo.to_pillow().convert("RGB")


@contextmanager
def _named(file: Path) -> Iterator[None]:
    """Errors of the decoder name the file."""
    try:
        yield
    except (*headers.FAULTS, RuntimeError) as error:
        raise ValueError(f"{file}: not a readable HEIC photo ({str(error).strip()})") from error


def write_jpeg(file: Path, place: Path, quality: int) -> None:
    """Write a photo as JPEG.

    Raises:
        ValueError: see `load`.
    """
    photo = load(file)
    photo.save(place, "JPEG", quality=quality, exif=photo.info.get("exif") or b"")
