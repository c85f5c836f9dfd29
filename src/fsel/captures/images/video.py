"""Frames out of a video, the sharpest of each stretch of time; and frames into a video to watch."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import chain
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.captures.images import files as image_files
from fsel.captures.images.previews import Progress, in_silence, variance_of_laplacian

ENDINGS = (".mp4", ".mov", ".m4v", ".mkv", ".avi", ".webm", ".mts", ".3gp")
DUAL = (".insv", ".insp", ".360", ".osv")  # what 360-degree cameras write
START = re.compile(rb"(?s)....(ftyp(?!hei|mif|avi)|moov|mdat|wide)|\x1aE\xdf\xa3|RIFF....AVI ")
MOST = 300  # frames that a video is thinned to by default
LEAST = 60  # and, of a short one, so many if it has them
RATE = 4.0  # of them a second: a person walks some 35 cm between two
FEWEST = 3
ROUNDED = 1.0  # seconds by which players round a video's length
SIDE = 480  # pixels of the longer side of the images whose sharpness is compared
HDR = (16, 18)  # transfer functions PQ and HLG (ITU-T H.273)
HEADER = 1 << 16  # bytes of a Matroska file in which it describes its streams
ENDS = 1 << 24  # bytes of an MP4, first and last, in which it does: the rest is images
TO_SDR = (
    "is HDR; its colours are read as coded and look flat. Hint: ffmpeg -i {path} -vf "
    "zscale=t=linear:npl=100,format=gbrpf32le,zscale=p=bt709,tonemap=hable,"
    "zscale=t=bt709:m=bt709:r=tv,format=yuv420p sdr.mp4"
)
COLUMNS = 64, 60  # pixels at which the ends of a panorama are compared: codecs blur finer ones
SEAM = 1.0  # of a panorama: its ends differ by so much of what neighbouring columns do, at most
BLANK = 0.5  # grey levels between columns, below which nothing is said

Spans = Sequence[tuple[float, float]]
"""Pairs of seconds, from and to."""
WHOLE: Spans = ((0.0, math.inf),)


@dataclass(frozen=True)
class SampledFrame:
    """A frame of a video."""

    index: int  # of the video's frames, from 0
    seconds: float  # from the start, by the video's clock
    sharpness: float  # variance of the Laplacian, comparable within a video

    @property
    def name(self) -> str:
        """File that it is written to."""
        return f"frame_{self.index:05d}.jpg"


def is_video(path: Path) -> bool:
    """Return whether a path is a file with a video's ending, or begins as one, but for `DUAL`."""
    ending = path.suffix.lower()
    if ending in (*ENDINGS, *DUAL) or not path.is_file():
        return ending in ENDINGS and path.is_file()
    with path.open("rb") as file:
        return START.match(file.read(16)) is not None


@dataclass(frozen=True)
class Sampling:
    """Number of frames that are taken of a video."""

    frames: int | None = None  # None for as many as `rate` gives
    rate: float | None = None  # a second; None for 4, at least `least` and at most 300 in all
    least: int = LEAST
    start: float = 0.0  # seconds of the part that they are taken of
    end: float | None = None  # None for the video's own

    @property
    def free(self) -> bool:
        """Check whether neither a number nor a rate was stated."""
        return self.frames is None and self.rate is None

    @property
    def spans(self) -> Spans:
        """The part in seconds."""
        return ((self.start, math.inf if self.end is None else self.end),)

    @property
    def stated(self) -> dict[str, Any]:
        """Its fields, but start and end of a whole video."""
        cut = {"start": self.start, "end": self.end}
        return {name: v for name, v in asdict(self).items() if name not in cut or v}

    def part(self, path: Path) -> tuple[int, float]:
        """Return frames and seconds of the part, 0 where unknown; refuse one without any frame."""
        film = _opened(path)
        count, per_second = film.get(cv2.CAP_PROP_FRAME_COUNT), film.get(cv2.CAP_PROP_FPS)
        if not (count > 0 and per_second > 0):
            return 0, 0.0
        lasts = count / per_second
        end = lasts if self.end is None else self.end
        if not self.start < min(end, lasts) or end >= lasts + ROUNDED:
            raise ValueError(
                f"{path}: --start is {self.start:g} s and --end {end:g} s; allowed: a start before "
                f"the end, and both within its {lasts:.1f} s"
            )
        seconds = min(end, lasts) - self.start
        return round(seconds * per_second), seconds

    def count(self, path: Path) -> int:
        """Return how many frames are taken of a video, 0 where it does not say."""
        frames, seconds = self.part(path)
        return min(frames, math.ceil(self.pace(path) * seconds - 1e-6))

    def pace(self, path: Path) -> float:
        """Return frames a second of a video."""
        lasts = self.part(path)[1]
        if self.frames is not None and lasts > 0:
            return self.frames / lasts
        if self.rate is not None or lasts <= 0:
            return self.rate or RATE
        return max(min(RATE, MOST / lasts), self.least / lasts)


def thin(
    path: Path, folder: Path, pace: float, *, within: Spans = WHOLE, progress: Progress = in_silence
) -> list[SampledFrame]:
    """Write the sharpest frame of each of many equal stretches of a video, as JPEG.

    Stretches are of equal time, not of equal numbers of frames, so that videos of variable rate
    are thinned evenly. Frames are turned upright as the file says. One frame is in memory.

    Args:
        folder: receives `frame_00000.jpg`, ..., numbered by the video's frames.
        pace: stretches a second, as `Sampling` says.
        within: which parts of it are looked at.
    """
    film = _opened(path)
    count, per_second = int(film.get(cv2.CAP_PROP_FRAME_COUNT)), film.get(cv2.CAP_PROP_FPS)
    kept: list[SampledFrame] = []
    best: tuple[SampledFrame, np.ndarray] | None = None
    stretch = -1
    for shot, image in progress(_shots(film, per_second, within), max(count, 0)):
        at = int(shot.seconds * pace + 1e-6)
        if best is not None and at > stretch:
            kept.append(_written(best, folder))
            best = None
        if best is None or shot.sharpness > best[0].sharpness:
            best = shot, image
        stretch = at
    if best is not None:
        kept.append(_written(best, folder))
    return kept


def _opened(path: Path) -> cv2.VideoCapture:
    film = image_files.open_video(path)
    film.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
    return film


def is_hdr(path: Path) -> bool:
    """Return whether a video says that its light is coded as HLG or PQ, in MP4, MOV or MKV."""
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
        spans = (max(len(content) - ENDS, 0), len(content)), (0, ENDS)
        boxes = (content.rfind(b"colrncl" + end, *span) for span in spans for end in (b"x", b"c"))
        at = next((box for box in boxes if box >= 0), -1)
        code = content[at + 11] if at >= 0 else 0
        found = content.find(b"\x55\xba\x81", 0, HEADER)  # Matroska's name of the same number
        return (code or (content[found + 3] if found >= 0 else 0)) in HDR


def is_panorama(image: np.ndarray) -> bool:
    """Return whether an (h, w, 3) image shows all directions: 2:1, and its ends join up."""
    height, width = image.shape[:2]
    if width != 2 * height:
        return False
    columns = cv2.resize(image, COLUMNS, interpolation=cv2.INTER_AREA).astype(np.float32)
    steps = np.abs(np.diff(columns, axis=1, append=columns[:, :1])).mean(axis=2)
    usual = steps[:, :-1].mean(axis=1)
    ends = np.median(steps[:, -1] / np.maximum(usual, BLANK))  # whatever edge lies there in a part
    return bool(usual.mean() > BLANK and ends <= SEAM)


def _shots(
    film: cv2.VideoCapture, per_second: float, within: Spans
) -> Iterator[tuple[SampledFrame, np.ndarray]]:
    """Yield frames with their times and sharpness; (h, w, 3) uint8 BGR, upright."""
    index, last, latest = 0, -1.0, max(end for _, end in within)
    while last <= latest and film.grab():
        seconds = film.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if not seconds > last:  # a container without times of its own
            seconds = index / per_second if per_second > 0 else float(index)
        last = seconds
        if any(start <= seconds <= end for start, end in within):
            done, image = film.retrieve()
            if done:
                grey, scale = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), SIDE / max(image.shape[:2])
                if scale < 1:
                    grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
                yield SampledFrame(index, seconds, variance_of_laplacian(grey)), image
        index += 1


def _written(best: tuple[SampledFrame, np.ndarray], folder: Path) -> SampledFrame:
    kept, image = best
    image_files.write(image[None, ..., ::-1], folder, [kept.name])
    return kept


CODECS = ("avc1", "vp09", "mp4v")  # of OpenCV: H.264 where its FFmpeg encodes it, VP9, MPEG-4
H264 = "libx264"  # of the system's ffmpeg, which is given these words and frames
RAW = "-y -v error -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate} -i - -c:v {codec} "
ENCODE = RAW + "-crf 18 -pix_fmt yuv420p -movflags +faststart"


def write_video(path: Path, frames: Iterable[np.ndarray], rate: float) -> None:
    """Write (h, w, 3) uint8 RGB frames of one size, in H.264 where the system's ffmpeg or OpenCV
    encodes it; an odd last row or column is left out."""
    frames = iter(frames)
    first = next(frames)
    height, width = (side // 2 * 2 for side in first.shape[:2])
    with _encoder(path, (width, height), rate) as encode:
        for frame in chain([first], frames):
            encode(np.ascontiguousarray(frame[:height, :width]))


@contextmanager
def _encoder(path: Path, size: image_files.Size, rate: float) -> Iterator[Any]:
    """Yield a function that takes the frames of a video of (width, height) in turn."""
    if program := shutil.which("ffmpeg"):
        known = subprocess.run([program, "-encoders"], capture_output=True, text=True).stdout
    if program and H264 in known:
        words = ENCODE.format(width=size[0], height=size[1], rate=rate, codec=H264).split()
        with subprocess.Popen([program, *words, path], stdin=subprocess.PIPE) as process:
            assert process.stdin is not None
            yield process.stdin.write
        if process.returncode:
            raise OSError(f"{path}: {program} ended with exit code {process.returncode}")
        return
    writer = cv2.VideoWriter()
    for codec in CODECS:
        if writer.open(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*codec), rate, size):
            break
    else:
        raise OSError(f"{path}: OpenCV has no codec for it; tried: {', '.join(CODECS)}")
    yield lambda frame: writer.write(frame[..., ::-1])
    writer.release()


def levels(image: np.ndarray) -> np.ndarray:
    """Return levels 0..255, uint8, of an image in [0, 1]."""
    return np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
