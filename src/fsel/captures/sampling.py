"""Frames sampled from the sources of a scene: videos, and folders of photos."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.failures import STANDS
from fsel.captures.colmap.runs import Work
from fsel.captures.images import files as image_files
from fsel.captures.images import video
from fsel.captures.images.files import Video, VideoFrame
from fsel.captures.parsing import read_json
from fsel.captures.quality.photometry import duplicates
from fsel.core.files import write_text
from fsel.core.subsets import evenly
from fsel.core.wording import counted

IMAGES, TAKEN = "images", "taken.json"
DENSER = 3.0  # times as many frames a second, where some were not placed
LOOKED, FIRST = 5, 75  # images that say if they show all directions; frames that they are of
STEP, SHORTER = 0.04, 0.9  # of the longer side that frames are apart; where too few are
THUMBNAIL = 96  # pixels of the longer side of images that are compared with their neighbours
Say = Callable[[str, str], None]


@dataclass(frozen=True)
class Source:
    """Video or photos of a scene, by one camera."""

    path: Path
    name: str = ""  # folder below images/; empty where there is one source alone
    photos: tuple[Path, ...] = ()  # in natural order of their names; none of a video
    panoramic: bool = False  # whether images show all directions

    @property
    def first(self) -> image_files.Image:
        """Return the first photo, or frame of the video."""
        return self.photos[0] if self.photos else VideoFrame(Video(self.path), 0)

    @property
    def filmed(self) -> bool:
        """Return whether it is a video."""
        return not self.photos

    def named(self, name: str) -> str:
        """Return the name of a frame in the capture."""
        return f"{self.name}/{name}" if self.name else name


def looked_at(source: Source) -> Source:
    """Return a source that says whether most of its images show all directions."""
    first = source.first
    width, height = image_files.size_of(first)
    if width != 2 * height:
        return source
    photos = [photo for photo in source.photos if not image_files.is_heic(photo)]
    few = [photos[i] for i in evenly(len(photos), LOOKED)]
    if isinstance(first, VideoFrame):
        frames = evenly(min(FIRST, video.Sampling().part(source.path)[0] or 1), LOOKED)
        few = [replace(first, index=i) for i in frames.tolist()]
    joined = sum(video.is_panorama(image_files.load(image)) for image in few)
    return replace(source, panoramic=2 * joined > len(few))


@dataclass
class SampledFrames:
    """Frames that were sampled from the sources; those of videos by the name of the source."""

    shots: dict[str, list[video.SampledFrame]]  # in order
    paces: dict[str, float]  # frames a second
    still: int  # how many were left out as equal to those before them
    turned: list[str]  # names of photos that were turned upright
    ends: dict[str, float] = field(default_factory=dict)  # seconds of the last, left out or not
    start: float = 0.0  # seconds that videos are taken from

    def save(self, folder: Path) -> None:
        """Store what was sampled, for a run that is resumed."""
        rows = {
            name: [list(asdict(shot).values()) for shot in shots]
            for name, shots in self.shots.items()
        }
        write_text(json.dumps(asdict(self) | {"shots": rows}), folder / TAKEN)

    @classmethod
    def of(cls, path: Path) -> SampledFrames:
        """Read what was stored; RuntimeError for a damaged file."""
        try:
            content = read_json(path)
            shots = content.pop("shots").items()
            shots = {name: [video.SampledFrame(*s) for s in rows] for name, rows in shots}
            return cls(shots, **content)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise RuntimeError(f"{path}: not what fsel stored ({error})") from error


def take(
    sources: Sequence[Source], sampling: video.Sampling, folder: Path, work: Work, say: Say
) -> SampledFrames:
    """Put frames and photos of the sources into images/, unless an earlier run has done so."""
    if (folder / TAKEN).is_file():
        return SampledFrames.of(folder / TAKEN)
    taken = SampledFrames({}, {}, 0, [], start=sampling.start)
    for source in sources:
        images = folder / IMAGES / source.name
        images.mkdir(parents=True, exist_ok=True)
        if not source.filmed:
            taken.turned += _put(source, images, work, say)
            continue
        pace = sampling.pace(source.path)
        part, watch = sampling.spans, work.watch("video")
        shots = video.thin(source.path, images, pace, within=part, progress=watch)
        moving = _moving(source, shots, images)
        if sampling.free and len(moving) < sampling.least <= len(shots):  # there is a pause
            pace *= sampling.least / len(moving)
            shots = video.thin(source.path, images, pace, within=part, progress=watch)
            moving = _moving(source, shots, images)
        still = len(shots) - len(moving)
        if sampling.free:
            moving = _overlapping(moving, images, sampling.least)
        taken.shots[source.name], taken.paces[source.name] = moving, pace
        taken.ends[source.name] = shots[-1].seconds
        taken.still += still
        said = f"the sharpest frame in each of {len(shots)} intervals of {source.path.name}"
        said += f"; dropped {counted(still, 'frame')} that repeat others" if still else ""
        near = len(shots) - still - len(moving)
        said += f"; {len(moving)} taken, which overlap enough" if near else ""
        say("video", said)
    taken.save(folder)
    return taken


def take_denser(
    source: Source, taken: SampledFrames, within: video.Spans, folder: Path, work: Work
) -> bool:
    """Take more frames of some parts of a video; return whether it has more."""
    shots, images = taken.shots[source.name], folder / IMAGES / source.name
    pace = taken.paces[source.name] = taken.paces[source.name] * DENSER
    watch = work.watch("video")
    found = video.thin(source.path, images, pace, within=within, progress=watch)
    known = {shot.index for shot in shots}
    new = [shot for shot in found if shot.index not in known]
    shots[:] = sorted([*shots, *new], key=lambda shot: shot.index)
    return bool(new)


def _moving(
    source: Source, shots: list[video.SampledFrame], images: Path
) -> list[video.SampledFrame]:
    """Return frames that differ from the one before them; the files of the others are removed."""
    keep = duplicates(_thumbnails(shots, images)) if shots else np.empty(0, bool)
    moving = [shot for shot, kept in zip(shots, keep, strict=True) if kept]
    for shot in set(shots) - set(moving):
        (images / shot.name).unlink()
    if len(shots) < video.FEWEST:
        raise ValueError(
            f"{source.path}: yields {counted(len(shots), 'frame')}; at least {video.FEWEST} are "
            "needed. Hint: `video_frames=N` or `rate=N` samples more frames"
        )
    if len(moving) < video.FEWEST:
        raise ValueError(
            f"{source.path}: {len(shots) - len(moving)} of {len(shots)} frames repeat the "
            f"previous one: {STANDS}"
        )
    return moving


def _thumbnails(shots: list[video.SampledFrame], images: Path) -> np.ndarray:
    small = []
    for shot in shots:
        image = image_files.load(images / shot.name, cv2.IMREAD_REDUCED_GRAYSCALE_2)
        scale = THUMBNAIL / max(image.shape)
        small.append(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    return np.array(small)


def _overlapping(
    shots: list[video.SampledFrame], images: Path, least: int
) -> list[video.SampledFrame]:
    """Return the sharpest frame of each stretch in which the image moves by `STEP`, of shorter ones
    where that leaves fewer than some; the files of the others are removed."""
    if len(shots) <= least:
        return shots
    small, step = _thumbnails(shots, images), STEP
    shares = [motion(one, other) for one, other in itertools.pairwise(small)]
    moved = np.concatenate([[0.0], np.cumsum(shares)])
    while len(np.unique(moved // step)) < least:
        step *= SHORTER
    best: dict[float, video.SampledFrame] = {}
    for shot, stretch in zip(shots, (moved // step).tolist(), strict=True):
        if stretch not in best or shot.sharpness > best[stretch].sharpness:
            best[stretch] = shot
    for shot in set(shots) - set(best.values()):
        (images / shot.name).unlink()
    return list(best.values())


def motion(one: np.ndarray, other: np.ndarray) -> float:
    """Return the median motion of the pixels of two (h, w) uint8 grey images, as a share of the
    longer side, by Farnebäck's optical flow (2003), which is the same on any number of threads."""
    flow = cv2.calcOpticalFlowFarneback(one, other, None, 0.5, 3, 15, 3, 5, 1.2, 0)
    return float(np.median(np.hypot(*flow.reshape(-1, 2).T))) / max(one.shape)


def _put(source: Source, folder: Path, work: Work, say: Say) -> list[str]:
    """Link photos, copy those upright whose EXIF asks for a turn, and return the latter's names."""
    turned = []
    for file in work.watch("photos")(source.photos, len(source.photos)):
        place = folder / photo_name(file)
        place.unlink(missing_ok=True)
        turn = image_files.orientation(file) != 1
        if turn or image_files.is_heic(file):
            image_files.write_photo(file, place, upright=True)
        else:
            place.symlink_to(file.resolve())
        if turn:
            turned.append(source.named(file.name))
    if turned:
        how = f"as their EXIF says; JPEGs encoded again at quality {image_files.QUALITY}"
        say("turned", f"{len(turned)} of {len(source.photos)} photos upright, {how}")
    return turned


def photo_name(file: Path) -> str:
    """Return a photo's name in the capture; beside IMG_1.HEIC phones keep an IMG_1.JPG."""
    return f"{file.name}.jpg" if image_files.is_heic(file) else file.name
