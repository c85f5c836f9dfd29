"""Images in files and videos: sizes, pixels, orientation, and how they are written."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from mmap import ACCESS_READ, mmap
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, BinaryIO

import cv2
import numpy as np

if TYPE_CHECKING:
    from PIL.Image import Image as Photo

FORMATS = ("JPEG", "PNG", "BMP", "WEBP", "TIFF", "HEIF")
HEIC = (".heic", ".heif")
HEIC_HINT = "pip install 'fsel[heic]'"
JPEG = (".jpg", ".jpeg")
ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}  # of JPEG and PNG, by their first bytes
TAIL = 1024  # last bytes that hold the end: some cameras write more behind it
ORIENTATION = 0x0112  # EXIF's tag of the turn that a photo is to be shown with; 1 for none
COLOR = {
    1: cv2.IMREAD_COLOR,
    2: cv2.IMREAD_REDUCED_COLOR_2,
    4: cv2.IMREAD_REDUCED_COLOR_4,
    8: cv2.IMREAD_REDUCED_COLOR_8,
}
"""By what the sides are divided by: how OpenCV decodes an image."""
HUGE = 1 << 25  # pixels from which a JPEG is decoded at a reduced size
QUALITY = 97  # of JPEGs that are written
ENCODING = {
    ".png": [cv2.IMWRITE_PNG_COMPRESSION, 1],
    **{ending: [cv2.IMWRITE_JPEG_QUALITY, QUALITY] for ending in JPEG},
}
HINT = (
    ". Hint: `skip_unreadable=True` leaves such frames out; a selection also leaves out those that "
    "`never=NAMES` names"
)
Size = tuple[int, int]


def open_video(path: Path) -> cv2.VideoCapture:
    """Return a video to read; refuse one that cannot be read, or whose end is missing."""
    film = cv2.VideoCapture(str(path))
    if not film.isOpened():
        with path.open("rb") as file:
            mp4 = file.read(8)[4:] == b"ftyp"
            cut = mp4 and mmap(file.fileno(), 0, access=ACCESS_READ).find(b"moov") < 0
        why = "truncated: its end, with the index of its frames, is missing. Hint: copy it again"
        raise ValueError(f"{path}: {why if cut else 'not a readable video'}")
    return film


class Video:
    """A video read frame by frame; fast when the frames are read in order."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._capture: cv2.VideoCapture | None = None
        self._next = 0
        self._lock = Lock()

    def read(self, index: int) -> np.ndarray:
        """Return the (h, w, 3) uint8 RGB frame at `index`."""
        with self._lock:
            if self._capture is None or index < self._next:
                self._capture, self._next = open_video(self.path), 0
            while self._next <= index:
                if not self._capture.grab():
                    raise ValueError(
                        f"{self.path}: ends after {self._next} frames, but frame {index} is needed"
                    )
                self._next += 1
            return cv2.cvtColor(self._capture.retrieve()[1], cv2.COLOR_BGR2RGB)


@dataclass(frozen=True)
class VideoFrame:
    """One frame of a video, which all of its frames share."""

    video: Video
    index: int  # from 0

    def __str__(self) -> str:
        return f"{self.video.path}: frame {self.index}"


Image = Path | VideoFrame


def is_there(image: Image) -> bool:
    """Check whether an image's file exists."""
    return (image.video.path if isinstance(image, VideoFrame) else image).exists()


@contextmanager
def opened(path: Path, content: BinaryIO | None = None) -> Iterator[Photo]:
    """Open an image by Pillow, which reads its header; errors in the block name the file.

    Raises:
        ValueError: for a file that is missing, empty, cut short, damaged, of another format, or
            larger than `PIL.Image.MAX_IMAGE_PIXELS` allows.
    """
    from PIL import Image  # here: not every command looks at images

    warnings.filterwarnings("ignore", module=r"PIL\.")  # of EXIF that is damaged, and the like
    if is_heic(path):
        import_module("pillow_heif").register_heif_opener()
    if not path.is_file():
        raise ValueError(f"{path}: image file is missing")
    with content or path.open("rb") as file:
        start, length = file.read(2), file.seek(0, os.SEEK_END)
        if not length:
            raise ValueError(f"{path}: image file is empty (0 bytes)")
        file.seek(max(0, length - TAIL))
        if ENDS.get(start, b"") not in file.read():  # decoders fill what lacks with grey
            raise ValueError(f"{path}: image file is truncated ({length} bytes)")
        try:
            with Image.open(file, formats=FORMATS) as photo:
                yield photo
        except Exception as error:  # what Pillow raises for damaged files is of many kinds
            raise ValueError(f"{path}: not a readable image ({error}){HINT}") from error


def size_of(source: Image) -> Size:
    """Return (width, height) of the stored pixels; that of a file is read from its header."""
    if isinstance(source, VideoFrame):
        height, width = source.video.read(source.index).shape[:2]
        return width, height
    with opened(source) as photo:
        return photo.size


def orientation(file: Path) -> int:
    """Return the turn that a photo's EXIF asks for, 1 to 8; 1 where it asks for none."""
    with opened(file) as photo:
        return _orientation(photo)


def _orientation(photo: Photo) -> int:
    try:
        value = photo.getexif().get(ORIENTATION, 1)
    except Exception:  # damaged EXIF asks for none
        return 1
    return value if value in range(1, 9) else 1


def load(source: Image, flags: int = cv2.IMREAD_COLOR) -> np.ndarray:
    """Read an (h, w, 3) uint8 RGB image, or (h, w) grey by OpenCV's `flags`, as stored, before any
    turn that EXIF asks for."""
    if isinstance(source, VideoFrame):
        image = source.video.read(source.index)
        return image if flags & cv2.IMREAD_COLOR else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    image = _decoded(source, flags)
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB) if image.ndim == 3 else image


def load_for(source: Image, long_side: int, *, approximate: bool = False) -> np.ndarray:
    """Read an (h, w, 3) uint8 RGB image for one of `long_side` pixels: a JPEG of more than 33
    million at a half, quarter or eighth where that is twice the size to come. If `approximate`,
    any JPEG where that is six times the size: pixels differ by 1 grey level on the mean."""
    if isinstance(source, VideoFrame) or source.suffix.lower() not in JPEG:
        return load(source)
    width, height = size_of(source)
    if width * height <= HUGE and not approximate:
        return load(source)
    times = 2 if width * height > HUGE else 6
    return load(source, COLOR[reduction(max(width, height), times * long_side)])


def reduction(longest: int, side: int) -> int:
    """Return the largest key of `COLOR` that leaves `side` of an image's `longest` pixels."""
    return max(factor for factor in COLOR if factor == 1 or longest // factor >= side)


def check_pixels(file: Image) -> None:
    """Refuse a file that no decoder takes, a JPEG at an eighth of its size; videos are skipped."""
    if isinstance(file, VideoFrame):
        return
    if is_heic(file):
        with opened(file) as photo:
            photo.load()
        return
    small = file.suffix.lower() in JPEG
    load(file, cv2.IMREAD_REDUCED_GRAYSCALE_8 if small else cv2.IMREAD_COLOR)


def fault(image: Image) -> str:
    """Return the fault of an image file, without its name; empty for a sound one or a video's."""
    try:
        check_pixels(image)
    except ValueError as error:
        return str(error).removeprefix(f"{image}: ").removesuffix(HINT)
    except OSError as error:
        return f"image file cannot be opened ({error.strerror})"
    return ""


def load_mask(source: Image, values: tuple[int, int]) -> np.ndarray:
    """Return (h, w) bool: where a mask's first channel lies within `values`, both included."""
    if isinstance(source, VideoFrame):
        grey = source.video.read(source.index)[..., 0]
    else:
        grey = _decoded(source, cv2.IMREAD_UNCHANGED)
        grey = grey[..., 0] if grey.ndim == 3 else grey
    return (grey >= values[0]) & (grey <= values[1])


def _decoded(path: Path, flags: int) -> np.ndarray:
    content = path.read_bytes() if path.is_file() else b""
    with opened(path, BytesIO(content)) as photo:
        turned = photo.format == "TIFF" and _orientation(photo) != 1
    if turned:  # OpenCV and Pillow turn it in any case, and cameras describe the rest
        raise ValueError(f"{path}: a rotated TIFF. Hint: save it upright, without")
    try:
        pixels = np.frombuffer(content, np.uint8)
        image = cv2.imdecode(pixels, flags | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        image = None
    if image is None:
        raise ValueError(
            f"{path}: not a readable image: its {len(content)} bytes cannot be decoded{HINT}"
        )
    return image


def is_heic(path: Path) -> bool:
    """Return whether a path has the ending of a photo as phones keep them."""
    return path.suffix.lower() in HEIC


def reads_heic() -> bool:
    """Return whether the package that reads such photos is installed."""
    return find_spec("pillow_heif") is not None


def write(frames: np.ndarray, folder: Path, names: list[str]) -> None:
    """Write (N, h, w, 3) RGB (or grey, or uint16) images; JPEG at quality 97, PNG lossless."""
    for frame, name in zip(frames, names, strict=True):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        stored = frame[..., ::-1] if frame.ndim == 3 else frame
        done, content = cv2.imencode(
            path.suffix, np.ascontiguousarray(stored), ENCODING[path.suffix.lower()]
        )
        if not done:
            raise ValueError(f"{path}: could not be encoded")
        path.write_bytes(content.tobytes())


def write_photo(file: Path, place: Path, *, upright: bool) -> None:
    """Write a photo again whose EXIF asks for no turn, a JPEG at quality 97.

    The rest of the EXIF is kept: COLMAP guesses focal lengths by it. The ending of the place says
    the format. Where `upright`, pixels are turned as the EXIF asks; else they stay as stored.
    """
    from PIL import ImageOps

    with opened(file) as photo:
        image = ImageOps.exif_transpose(photo) if upright else photo.copy()
        exif = image.getexif()
    if ORIENTATION in exif:
        del exif[ORIENTATION]
    image = image.convert("RGB") if is_heic(file) else image
    image.save(place, quality=QUALITY, exif=exif)
