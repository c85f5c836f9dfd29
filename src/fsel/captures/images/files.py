"""Images in files and videos: opening, writing, and storing them as one array."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from threading import Lock
from types import TracebackType
from typing import BinaryIO

import cv2
import numpy as np

from fsel.captures.images import headers, heic, orientation
from fsel.core.files import atomic, mapped_array

COLOR = {
    1: cv2.IMREAD_COLOR,
    2: cv2.IMREAD_REDUCED_COLOR_2,
    4: cv2.IMREAD_REDUCED_COLOR_4,
    8: cv2.IMREAD_REDUCED_COLOR_8,
}
"""By what the sides are divided by: how OpenCV decodes an image."""
HUGE = 1 << 25  # pixels from which a JPEG is decoded at a reduced size
JPEG = (".jpg", ".jpeg")
QUALITY = 97  # of JPEGs that are written
ENCODING = {
    ".png": [cv2.IMWRITE_PNG_COMPRESSION, 1],
    **{ending: [cv2.IMWRITE_JPEG_QUALITY, QUALITY] for ending in JPEG},
}
HINT = (
    ". Hint: `skip_unreadable` (--skip-unreadable) leaves such frames out; `fsel select` also "
    "leaves those that --never names"
)


class Video:
    """A video read frame by frame; fast when the frames are read in order."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._capture: cv2.VideoCapture | None = None
        self._next = 0
        self._lock = Lock()

    def read(self, index: int) -> np.ndarray:
        """(h, w, 3) uint8 RGB of the frame at `index`.

        Raises:
            ValueError: when the video cannot be opened or ends before.
        """
        with self._lock:
            if self._capture is None or index < self._next:
                self._capture, self._next = cv2.VideoCapture(str(self.path)), 0
                if not self._capture.isOpened():
                    raise ValueError(f"{self.path}: not a readable video")
            while self._next <= index:
                if not self._capture.grab():
                    raise ValueError(
                        f"{self.path}: ends after {self._next} frames, {index} is wanted"
                    )
                self._next += 1
            return np.ascontiguousarray(self._capture.retrieve()[1][..., ::-1])


@dataclass(frozen=True)
class VideoFrame:
    """One frame of a video.

    Attributes:
        video: shared by all of its frames.
        index: from 0.
    """

    video: Video
    index: int

    def __str__(self) -> str:
        return f"{self.video.path}: frame {self.index}"


Image = Path | VideoFrame


def load(source: Image, flags: int = cv2.IMREAD_COLOR) -> np.ndarray:
    """(h, w, 3) uint8 RGB image, or (h, w) grey where `flags`, OpenCV's of a file, say so.

    Pixels are as the file stores them: cameras describe those, before any turn that EXIF asks for.

    Raises:
        ValueError: for a missing, empty or truncated file, named.
    """
    if isinstance(source, VideoFrame):
        image = source.video.read(source.index)
        return image if flags & cv2.IMREAD_COLOR else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    image = _decoded(source, flags)
    return image[..., ::-1] if image.ndim == 3 else image


def load_for(source: Image, long_side: int) -> np.ndarray:
    """(h, w, 3) uint8 RGB image for one whose longer side has `long_side` pixels.

    A JPEG of more than 33 million pixels is decoded at a half, a quarter or an eighth of its size
    where that still is twice the size to come: an eighth of a panorama of 160 million pixels takes
    8 MB in place of 480. Other formats are decoded whole.

    Raises:
        ValueError: see `load`.
    """
    if isinstance(source, VideoFrame) or source.suffix.lower() not in JPEG:
        return load(source)
    width, height = headers.check(source)
    if width * height <= HUGE:
        return load(source)
    return load(source, COLOR[reduction(max(width, height), 2 * long_side)])


def reduction(longest: int, side: int) -> int:
    """The largest key of `COLOR` that leaves `side` of an image's `longest` pixels."""
    return max(factor for factor in COLOR if factor == 1 or longest // factor >= side)


def size_of(source: Image) -> headers.Size:
    """(width, height) of an image in pixels; that of a file is read from its header.

    Raises:
        ValueError: see `load`.
    """
    if isinstance(source, VideoFrame):
        height, width = source.video.read(source.index).shape[:2]
        return width, height
    return headers.check(source)


def check_pixels(file: Path) -> None:
    """Decode a file, a JPEG at an eighth of its size, to refuse one that no decoder takes.

    Raises:
        ValueError: see `load`.
    """
    if heic.is_heic(file):
        heic.load(file)
        return
    small = file.suffix.lower() in JPEG
    load(file, cv2.IMREAD_REDUCED_GRAYSCALE_8 if small else cv2.IMREAD_COLOR)


def fault(image: Image) -> str:
    """Fault that `headers.check` or `check_pixels` find in an image file, without its name.

    Nothing where it is sound, or for a frame of a video, which is left to the decoder.
    """
    if isinstance(image, VideoFrame):
        return ""
    try:
        if not heic.is_heic(image):
            headers.check(image)
        check_pixels(image)
    except ValueError as error:
        return str(error).removeprefix(f"{image}: ").removesuffix(HINT)
    except OSError as error:
        return f"image file cannot be opened ({error.strerror})"
    return ""


def load_mask(source: Image, values: tuple[int, int]) -> np.ndarray:
    """(h, w) bool: where a mask's first channel lies within `values`, both included.

    Raises:
        ValueError: for a missing, empty or truncated file, named.
    """
    if isinstance(source, VideoFrame):
        grey = source.video.read(source.index)[..., 0]
    else:
        grey = _decoded(source, cv2.IMREAD_UNCHANGED)
        grey = grey[..., 0] if grey.ndim == 3 else grey
    return (grey >= values[0]) & (grey <= values[1])


def _decoded(path: Path, flags: int) -> np.ndarray:
    if not path.is_file():
        raise ValueError(f"{headers.shown(path)}: image file is missing")
    content = path.read_bytes()
    if headers.opened(BytesIO(content), path).format == "TIFF":
        content = orientation.taken_out(content, path)  # OpenCV turns it whatever the flags say
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


def write_upright(file: Path, place: Path) -> None:
    """Write a photo turned as its EXIF asks, under a name of the same ending.

    A JPEG is encoded again at quality 97. The EXIF is kept, with orientation 1: COLMAP guesses
    focal lengths by it.

    Raises:
        ValueError: see `load`.
    """
    from PIL import Image, ImageOps  # here: most photos are upright

    photo = Image.fromarray(np.ascontiguousarray(load(file)))
    photo.getexif()[orientation.ORIENTATION] = orientation.of_file(file)
    upright = ImageOps.exif_transpose(photo)
    upright.save(place, quality=QUALITY, exif=orientation.upright_exif(file))


class ArrayFile:
    """(count, ...) array that is filled item by item: in memory, or on disk as a .npy file.

    On disk the items are appended, so that memory holds one of them whatever their number; the
    file appears under its name when the block ends without an error.
    """

    def __init__(self, count: int, path: Path | None) -> None:
        self._count, self._path = count, path
        self._items: list[np.ndarray] = []
        self._file: BinaryIO | None = None
        self._stack = ExitStack()

    def __enter__(self) -> ArrayFile:
        if self._path is not None:
            partial = self._stack.enter_context(atomic(self._path))
            self._file = self._stack.enter_context(partial.open("wb"))
        return self

    def append(self, item: np.ndarray) -> None:
        """Store the next item; all share one shape and type."""
        if self._file is None:
            self._items.append(item)
            return
        if not self._file.tell():
            header = {
                "descr": np.lib.format.dtype_to_descr(item.dtype),
                "fortran_order": False,
                "shape": (self._count, *item.shape),
            }
            np.lib.format.write_array_header_1_0(self._file, header)
        self._file.write(np.ascontiguousarray(item).data)

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def array(self) -> np.ndarray:
        """All items, after the block: an array, or a read-only map of the file."""
        return np.stack(self._items) if self._path is None else mapped_array(self._path)
