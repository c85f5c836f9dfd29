"""Captures out of videos and photos: frames are placed, and taken denser where that fails."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from fsel.colmap.bindings import pycolmap
from fsel.colmap.failures import STANDS
from fsel.colmap.model import write_binary
from fsel.colmap.runs import MIN_PLACED, Part, Work
from fsel.data.geometry import upright
from fsel.health import duplicates
from fsel.images import files as image_files
from fsel.images import orientation, video
from fsel.ingest import sfm
from fsel.layouts import bare
from fsel.layouts.contract import RawCapture
from fsel.utils.names import natural
from fsel.utils.wording import counted

IMAGES, MODEL, TAKEN = "images", "sparse/0", "taken.json"
ROUNDS = 2  # of taking frames denser
DENSER = 3.0  # times as many a second, each round
THUMBNAIL = 96  # pixels of the longer side of images that are compared with their neighbours
Say = Callable[[str, str], None]


@dataclass(frozen=True)
class Source:
    """Video or photos of a scene, by one camera.

    Attributes:
        path: the video, or the folder.
        name: folder below images/; empty where there is one source alone.
        photos: files, in natural order of their names; none of a video.
    """

    path: Path
    name: str = ""
    photos: tuple[Path, ...] = ()

    @property
    def filmed(self) -> bool:
        """Check whether it is a video."""
        return not self.photos

    def named(self, name: str) -> str:
        """Name of a frame in the capture."""
        return f"{self.name}/{name}" if self.name else name


@dataclass
class Taken:
    """Frames that were taken of the sources.

    Attributes:
        shots: by a video's name, its frames in order.
        paces: by a video's name, frames a second.
        still: by a video's name, how many frames were left out as equal to those before them.
        turned: names of photos that were turned upright.
    """

    shots: dict[str, list[video.Kept]]
    paces: dict[str, float]
    still: dict[str, int]
    turned: list[str]


def place(
    sources: Sequence[Source], sampling: video.Sampling, folder: Path, work: Work, say: Say
) -> dict:
    """Fill a folder with a COLMAP capture of the sources, and return what was found.

    Frames of a video that show the same as the one before them are left out. Where two frames or
    more of a video in a row could not be placed, frames are taken denser, twice at most, as long
    as that helps.

    Args:
        sources: one or more.
        sampling: of each video.
        folder: receives images/ and sparse/0; what an interrupted run left in it is gone on with.
        work: how COLMAP runs; its folder outlives interruptions.
        say: prints a line of a step, by a label.

    Returns:
        As `poses.json` has it: names of frames that were placed and not, times that were lost.

    Raises:
        ValueError: for what cannot be read, or where fewer than three frames can be placed, with
            the cause.
    """
    taken = _taken(sources, sampling, folder, work, say)
    model, rounds, placed = None, 0, set[str]()
    while True:
        raw, parts = _raw(sources, taken, folder)
        before = len(placed)
        try:
            model = sfm.place(raw, work=replace(work, parts=parts), start=model)
        except sfm.NotPlaced as error:
            if error.cause or rounds == ROUNDS or not _denser(sources, taken, placed, folder, work):
                raise _refused(sources, error) from error
        else:
            placed = {image.name for image in model.images.values()}
            in_vain = rounds == ROUNDS or len(placed) == before
            if in_vain or not _denser(sources, taken, placed, folder, work):
                break
        rounds += 1
        say("video", "frames were not placed: taken denser there")
        _keep(taken, folder)
    turn_upright(model)
    write_binary(model, folder / MODEL)
    return _found(sources, taken, raw, model)


def turn_upright(model: pycolmap.Reconstruction) -> None:
    """Turn a world that COLMAP chose until z points upwards."""
    poses = [image.cam_from_world().matrix() for image in model.images.values()]
    turn = pycolmap.Rotation3d(upright(np.array(poses)))
    model.transform(pycolmap.Sim3d(1.0, turn, np.zeros(3)))


def _refused(sources: Sequence[Source], error: sfm.NotPlaced) -> ValueError:
    several = "videos" if any(source.filmed for source in sources) else "photos"
    usual = f"the {several} show too little in common. Hint: more images that overlap each other"
    if several == "videos":
        usual += ", as of a slower walk"
    paths = ", ".join(str(source.path) for source in sources)
    return ValueError(
        f"{paths}: {error.said}; at least {MIN_PLACED} are needed: {error.cause or usual}"
    )


def _taken(
    sources: Sequence[Source], sampling: video.Sampling, folder: Path, work: Work, say: Say
) -> Taken:
    """Frames and photos of the sources, put into images/, as an earlier run left them if it did."""
    if (folder / TAKEN).is_file():
        content = json.loads((folder / TAKEN).read_text(encoding="utf-8"))
        shots = content.pop("shots").items()
        return Taken({name: [video.Kept(*s) for s in rows] for name, rows in shots}, **content)
    taken = Taken({}, {}, {}, [])
    for source in sources:
        images = folder / IMAGES / source.name
        images.mkdir(parents=True, exist_ok=True)
        if source.filmed:
            pace = taken.paces[source.name] = sampling.pace(source.path)
            shots = video.thin(source.path, images, pace, progress=work.watch("video"))
            moving = _moving(source, shots, images)
            taken.shots[source.name] = moving
            taken.still[source.name] = len(shots) - len(moving)
            still = f"; {counted(len(shots) - len(moving), 'frame')} like the one before left out"
            said = f"the sharpest of each of {len(shots)} stretches of {source.path.name}"
            say("video", said + still * (len(moving) < len(shots)))
        else:
            taken.turned += _put(source, images, work, say)
    _keep(taken, folder)
    return taken


def _keep(taken: Taken, folder: Path) -> None:
    """Store what was taken, for a run that is gone on with."""
    rows = {
        name: [list(asdict(shot).values()) for shot in shots] for name, shots in taken.shots.items()
    }
    partial = folder / f".{TAKEN}"
    partial.write_text(json.dumps(asdict(taken) | {"shots": rows}), encoding="utf-8")
    partial.replace(folder / TAKEN)


def _moving(source: Source, shots: list[video.Kept], images: Path) -> list[video.Kept]:
    """Frames that differ from the one before them; the files of the others are removed.

    Raises:
        ValueError: when fewer than three frames are left.
    """
    small = []
    for shot in shots:
        image = image_files.load(images / shot.name, cv2.IMREAD_REDUCED_GRAYSCALE_2)
        scale = THUMBNAIL / max(image.shape)
        small.append(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    keep = duplicates(np.array(small)) if shots else np.empty(0, bool)
    for shot, kept in zip(shots, keep, strict=True):
        if not kept:
            (images / shot.name).unlink()
    moving = [shot for shot, kept in zip(shots, keep, strict=True) if kept]
    if len(shots) < video.FEWEST:
        raise ValueError(
            f"{source.path}: gives {counted(len(shots), 'frame')}; at least {video.FEWEST} are "
            "needed. Hint: --video-frames or --rate take more of it"
        )
    if len(moving) < video.FEWEST:
        raise ValueError(
            f"{source.path}: {len(shots) - len(moving)} of {len(shots)} frames show the same as "
            f"the one before them: {STANDS}"
        )
    return moving


def _put(source: Source, folder: Path, work: Work, say: Say) -> list[str]:
    """Links to photos, and upright copies of those whose EXIF asks for a turn, which are named."""
    turned = []
    for file in work.watch("photos")(source.photos, len(source.photos)):
        place = folder / file.name
        place.unlink(missing_ok=True)
        if orientation.of_file(file) == orientation.UPRIGHT:
            place.symlink_to(file.resolve())
        else:
            image_files.write_upright(file, place)
            turned.append(source.named(file.name))
    if turned:
        how = f"as their EXIF says; JPEGs encoded again at quality {image_files.QUALITY}"
        say("turned", f"{len(turned)} of {len(source.photos)} photos upright, {how}")
    return turned


def _raw(sources: Sequence[Source], taken: Taken, folder: Path) -> tuple[RawCapture, list[Part]]:
    """The frames without poses, source after source, and what COLMAP is told of each source."""
    names, parts = [], []
    for source in sources:
        shots = taken.shots.get(source.name, ())
        numbers = [shot.index for shot in shots] or range(len(source.photos))
        files = [shot.name for shot in shots] or [photo.name for photo in source.photos]
        parts.append(Part(numbers, ordered=source.filmed))
        names += [source.named(name) for name in files]
    return bare.of_files(names, [folder / IMAGES / name for name in names]), parts


def _denser(
    sources: Sequence[Source], taken: Taken, placed: set[str], folder: Path, work: Work
) -> bool:
    """Take more frames where two or more in a row were not placed; false where there are none."""
    more = False
    for source in sources:
        if not source.filmed:
            continue
        shots, images = taken.shots[source.name], folder / IMAGES / source.name
        lost = [(low, high) for low, high, count in _lost(source, shots, placed) if count > 1]
        taken.paces[source.name] *= DENSER
        if lost:
            watch, pace = work.watch("video"), taken.paces[source.name]
            found = video.thin(source.path, images, pace, within=lost, progress=watch)
            known = {shot.index for shot in shots}
            new = [shot for shot in found if shot.index not in known]
            shots[:] = sorted([*shots, *new], key=lambda shot: shot.index)
            more = more or bool(new)
    return more


def _lost(
    source: Source, shots: Sequence[video.Kept], placed: set[str]
) -> list[tuple[float, float, int]]:
    """Seconds from one placed frame to the next, or to an end, with the frames lost between."""
    spans, start, count = [], 0.0, 0
    for shot in shots:
        if source.named(shot.name) not in placed:
            count += 1
            continue
        if count:
            spans.append((start, shot.seconds, count))
        start, count = shot.seconds, 0
    return [*spans, (start, shots[-1].seconds, count)] if count else spans


def _found(
    sources: Sequence[Source], taken: Taken, raw: RawCapture, model: pycolmap.Reconstruction
) -> dict:
    """Content of `poses.json`."""
    placed = {image.name for image in model.images.values()}
    films = [source for source in sources if source.filmed]
    lost = [
        {"video": source.path.name, "from": low, "to": high, "frames": count}
        for source in films
        for low, high, count in _lost(source, taken.shots[source.name], placed)
    ]
    shots = [
        {"name": source.named(shot.name)} | asdict(shot)
        for source in films
        for shot in taken.shots[source.name]
    ]
    ordered = sorted(raw.names, key=natural)
    return {
        "video": shots,
        "turned": taken.turned,
        "still": sum(taken.still.values()),
        "frames": len(raw.names),
        "placed": [name for name in ordered if name in placed],
        "not_placed": [name for name in ordered if name not in placed],
        "lost": lost,
    }
