"""Opening of what holds a capture; poses of a video or of photos are found by COLMAP and kept."""

from __future__ import annotations

import hashlib
import json
import math
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fsel.captures.canonical import in_order, ingest
from fsel.captures.colmap import features
from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.estimator import Estimator, program
from fsel.captures.colmap.runs import MIN_PLACED, Work, plan
from fsel.captures.colmap.search_time import SearchTime
from fsel.captures.images import files as image_files
from fsel.captures.images import video
from fsel.captures.images.previews import check_pixels
from fsel.captures.layouts import bare
from fsel.captures.lazy import LONG_SIDE, LazyCapture, open_capture
from fsel.captures.parsing import read_json
from fsel.captures.poses import kept, placement, positions
from fsel.captures.poses.kept import CAPTURE, FOUND, LOCK, MATCHING
from fsel.captures.poses.placement import SHOWN, first_of, notes
from fsel.captures.reporter import SILENT, Reporter
from fsel.captures.sampling import Source, looked_at, take
from fsel.core.files import cache, write_text
from fsel.core.limits import MAX_ERROR, threads
from fsel.core.names import check_utf8, distinct
from fsel.core.wording import counted

UNREAD = (*image_files.HEIC, *bare.RAW, ".avif", ".webp", ".tif", ".tiff", ".bmp")  # not for COLMAP
TIMES = 3  # frames that a video is thinned to, for each that is to be picked of it
KEPT = "progress is saved; run the same command again to resume"
MADE = 8  # of what is kept: counted up where the same files are placed otherwise than before


@dataclass(frozen=True)
class Opening:
    """What holds a capture, and how it becomes one, see `fsel.captures.read.read_folder`."""

    paths: tuple[Path, ...]  # a capture's folder; or videos and folders of photos of one scene
    poses: str = "layout"  # or `colmap`
    features: str | None = None  # what COLMAP matches; None for SIFT
    pose_time: float | None = None  # seconds for finding poses, see `SearchTime`
    by: tuple[str, ...] = ()  # commands of the program that finds poses; empty for COLMAP
    pose_masks: str | None = None  # folder of masks that COLMAP keeps features to
    mask_by: tuple[str, ...] = ()  # commands of the program that makes such masks
    video_frames: int | None = None  # that a video is thinned to
    rate: float | None = None  # frames a second that it is thinned to
    start: float = 0.0  # seconds of the part of a video that is taken
    end: float | None = None
    layout: str = "auto"
    max_error: float = MAX_ERROR
    skip_unreadable: bool = False
    wanted: int = 0  # the most frames that are to be picked; 0 where no number is stated
    views: bool = False  # whether views of panoramas are picked one by one


def opened(
    opening: Opening, reporter: Reporter = SILENT, long_side: int = LONG_SIDE
) -> LazyCapture:
    """Open a capture, or the one that COLMAP makes of a video or photos.

    Refuses options that do not fit, and all that `open_capture` refuses.
    """
    first = opening.paths[0]
    filmed = any(video.is_video(path) for path in opening.paths)
    sought = filmed or opening.poses == "colmap" or len(opening.paths) > 1
    if not filmed and (opening.video_frames or opening.rate or opening.start or opening.end):
        raise ValueError(f"{first}: is no video, as --video-frames, --rate, --start and --end need")
    of_poses = {"--features": opening.features, "--masks poses:DIR": opening.pose_masks}
    of_poses["--pose-time"] = str(opening.pose_time or "")
    if (what := next((name for name, value in of_poses.items() if value), "")) and not sought:
        raise ValueError(f"{first}: {what} is for poses by COLMAP. Hint: `poses=colmap`")
    if not sought:
        with reporter.clock("reading"):
            capture = open_capture(
                first,
                opening.layout,
                long_side,
                opening.max_error,
                skip_unreadable=opening.skip_unreadable,
            )
        warn_of(capture.skipped, reporter)
        return capture
    place, found = found_poses(opening, reporter)
    _check_number(opening, found)
    capture = open_capture(place / CAPTURE, "colmap", long_side, opening.max_error)
    known = f"colmap at {', '.join(str(path) for path in opening.paths)}"
    return replace(capture, capture=replace(capture.capture, source=known), found=found)


def warn_of(skipped: dict[str, str], reporter: Reporter) -> None:
    """Name the frames whose images cannot be read."""
    if skipped:
        named = [f"{name} ({why})" for name, why in skipped.items()]
        reporter.warn(f"{counted(len(named), 'image')} skipped: {first_of(named)}")


def found_poses(opening: Opening, reporter: Reporter) -> tuple[Path, dict]:
    """A folder with `capture`, a COLMAP capture, and `poses.json`; and what that says.

    It lies in the user's cache, under a digest of the files and settings: the second time nothing
    is matched, and a run that was cut off goes on where it was.
    """
    by, kind = program(opening.by, "by"), opening.features or features.SIFT
    masks = _masks(opening)
    sources, sampling = _sources(opening, reporter)
    place = cache() / _digest(sources, sampling, by, kind, masks, opening.pose_time)
    place.mkdir(parents=True, exist_ok=True)
    with kept.locked(place / LOCK):
        report = kept.found_in(place, reporter)
        if report is None:
            if not features.fetched(kind):
                reporter.say("features", f"fetching the weights of {kind}, once")
            features.check(kind)
            said = _plan(opening, sources, sampling)
            if not by and kind == features.SIFT:
                reporter.say("plan", said)
            if not opening.skip_unreadable:
                check_pixels([photo for source in sources for photo in source.photos])
            work = Work(place / MATCHING, watch=reporter.bar, by=by, features=kind, masks=masks)
            work = replace(work, time=SearchTime(opening.pose_time))
            found = _placed(sources, sampling, place, work, reporter)
            paths = [str(source.path) for source in sources]
            stated = {"sources": paths, "settings": sampling.stated}
            shutil.rmtree(place / MATCHING)
            write_text(json.dumps(stated | found, indent=1), place / FOUND)  # last
            report = read_json(place / FOUND)
    reporter.say(
        "poses", f"{report['by']} placed {len(report['placed'])} of {report['frames']} frames"
    )
    if gps := report.get("gps"):
        reporter.say("gps", positions.in_words(gps, len(report["placed"])))
    hint = "" if by or kind != features.SIFT else ". Hint: --features aliked may do better"
    for note in notes(report):
        reporter.warn(note + hint)
    return place, report


def _placed(
    sources: Sequence[Source], sampling: video.Sampling, place: Path, work: Work, reporter: Reporter
) -> dict:
    """Place the frames, anew where what a run that was cut off left is damaged."""
    begun = (place / CAPTURE).is_dir()
    try:
        return placement.place(sources, sampling, place / CAPTURE, work, reporter.say)
    except KeyboardInterrupt:
        reporter.warn(KEPT)
        raise
    except (OSError, ValueError, RuntimeError) as error:
        kept.check_room(place)
        if not (begun and isinstance(error, RuntimeError)):  # COLMAP's for its database
            raise
        kept.clear(place, error, reporter)
    return _placed(sources, sampling, place, work, reporter)


def unposed(opening: Opening, folder: Path, reporter: Reporter = SILENT) -> LazyCapture:
    """Put frames of videos and photos into a folder, and open them without looking for poses.

    Cameras on a line in the frames' order take the place of poses: frame health compares
    neighbours by them.
    """
    sources, sampling = _sources(opening, reporter)
    source = ", ".join(str(path) for path in opening.paths)
    taken = take(sources, sampling, folder, Work(watch=reporter.bar), reporter.say)
    raw, _ = placement.unplaced(sources, taken, folder)
    poses = np.tile(np.eye(3, 4), (len(raw.names), 1, 1))
    poses[:, 0, 3] = -np.arange(len(poses))
    cameras = [bare.guess(image_files.size_of(file)) for file in raw.images]
    raw = in_order(replace(raw, world_to_camera=poses, cameras=cameras), source)
    return LazyCapture("images", raw, ingest(raw, source, LONG_SIDE, lazy=True))


def _masks(opening: Opening) -> Path | Estimator | None:
    """Return the folder of masks that features are kept to, or the program that makes them."""
    if opening.by and (opening.pose_masks or opening.mask_by):
        raise ValueError(f"{opening.paths[0]}: masks are for COLMAP, not for --by")
    if opening.pose_masks is None:
        return program(opening.mask_by, "mask-by")
    if not Path(opening.pose_masks).is_dir():
        raise FileNotFoundError(f"{opening.pose_masks}: no such folder of masks")
    return Path(opening.pose_masks)


def _check_number(opening: Opening, found: dict) -> None:
    """Refuse to pick more frames than were placed, with the rate that would give enough."""
    wanted, placed = opening.wanted, len(found["placed"])
    if wanted < placed:
        return
    hint = "add photos" if not found["video"] else "record a longer video, or walk more slowly"
    ends = {Path(shot["name"]).parent: shot for shot in found["video"]}.values()
    if found["frames"] < sum(shot["index"] for shot in ends):
        lasts = max(1, sum(shot["seconds"] for shot in ends) - opening.start)
        rate = math.ceil(max(TIMES * wanted, 2 * len(found["video"])) / lasts)
        hint = f"--rate {rate} samples more frames"
    raise ValueError(
        f"{opening.paths[0]}: k is {wanted}, but {found['by']} placed {placed} of "
        f"{found['frames']} frames; allowed: up to {placed - 1}. Hint: {hint}"
    )


def _plan(opening: Opening, sources: Sequence[Source], sampling: video.Sampling) -> str:
    """Say what is to be placed, before any video is decoded; refuse to pick more frames."""
    counts = [sampling.count(s.path) if s.filmed else len(s.photos) for s in sources]
    count, filmed = sum(counts), any(source.filmed for source in sources)
    if not all(counts):  # a video that does not state how long it is
        return "a video of unknown length"
    if opening.wanted >= count:
        hint = "a longer video, or a higher --rate" if filmed else "more photos"
        raise ValueError(
            f"{opening.paths[0]}: k is {opening.wanted}, and {counted(count, 'frame')} are there "
            f"to be placed; allowed: up to {count - 1}. Hint: {hint}"
        )
    pixels = math.prod(image_files.size_of(sources[0].first))
    return plan(count, pixels, ordered=filmed, cores=threads())


def _sources(opening: Opening, reporter: Reporter) -> tuple[list[Source], video.Sampling]:
    """Return the videos and folders of photos of one scene, and how the videos are thinned."""
    paths = opening.paths
    if len({path.resolve() for path in paths}) < len(paths):
        raise ValueError(f"{paths[0]}: the same video or folder is given twice")
    names = [""] if len(paths) == 1 else distinct([path.stem for path in paths])
    photos = [() if video.is_video(path) else _photos(path, opening, reporter) for path in paths]
    sources = [looked_at(Source(*one)) for one in zip(paths, names, photos, strict=True)]
    if len({source.panoramic for source in sources}) > 1:
        raise ValueError(f"{paths[0]}: panoramas (2:1) and other images cannot be placed together")
    if opening.views and not sources[0].panoramic:
        raise ValueError(f"{paths[0]}: `views=True` is for panoramas (2:1); it is none")
    if sources[0].panoramic and opening.by:
        raise ValueError(f"{paths[0]}: is a 360-degree panorama, which --by does not support")
    for path in (source.path for source in sources if source.filmed and video.is_hdr(source.path)):
        reporter.warn(f"{path}: {video.TO_SDR.format(path=path)}")
    films = sum(source.filmed for source in sources)
    least = video.LEAST
    if opening.video_frames is None and opening.rate is None and films:
        least = -(-max(video.LEAST, TIMES * opening.wanted) // films)
    sampling = video.Sampling(opening.video_frames, opening.rate, least, opening.start, opening.end)
    if films > 1 and sampling.spans != video.WHOLE:
        raise ValueError(f"{films} videos are given; --start and --end apply to a single one")
    return sources, sampling


def _photos(source: Path, opening: Opening, reporter: Reporter) -> tuple[Path, ...]:
    """The photos of a folder; without `--skip-unreadable` all must be sound."""
    if not source.is_dir():
        why = "is neither a video nor a folder of photos" if source.exists() else "no such folder"
        raise ValueError(f"{source}: {why}{bare.explained(source)}")
    readable = (*bare.ENDINGS, *image_files.HEIC) if image_files.reads_heic() else bare.ENDINGS
    files = bare.find(source, readable)
    for file in files:
        check_utf8(file)
    if opening.skip_unreadable:
        faults = {file.name: image_files.fault(file) for file in files}
        warn_of({name: why for name, why in faults.items() if why}, reporter)
        files = [file for file in files if not faults[file.name]]
    there = [file for file in source.iterdir() if file.suffix.lower() not in readable]
    if other := sorted(file.name for file in there if file.suffix.lower() in UNREAD):
        hint = f". Hint: {image_files.HEIC_HINT}" if any(map(image_files.is_heic, there)) else ""
        hint += bare.RAW_HINT if any(file.suffix.lower() in bare.RAW for file in there) else ""
        reporter.warn(
            f"{counted(len(other), 'photo')} skipped; convert to JPEG or PNG to use them: "
            f"{', '.join(other[:SHOWN])}{hint}"
        )
    least = 1 if len(opening.paths) > 1 else MIN_PLACED
    empty = "" if any(source.iterdir()) else "; the folder is empty"
    if len(files) < least:
        raise ValueError(
            f"{source}: {counted(len(files), 'photo')} ({', '.join(readable)}) in it, in "
            f"images or in input; needed: {least} or more{empty}"
        )
    return tuple(files)


def _digest(
    sources: Sequence[Source],
    sampling: video.Sampling,
    by: Estimator | None,
    kind: str,
    masks: Path | Estimator | None,
    limit: float | None = None,
) -> str:
    files = [file for source in sources for file in source.photos or [source.path]]
    files += [file for s in sources if s.filmed and (file := positions.subtitles(s.path))]
    files += sorted(masks.rglob("*")) if isinstance(masks, Path) else []
    stamps = [(str(file.resolve()), file.stat().st_size, file.stat().st_mtime_ns) for file in files]
    names = [source.name for source in sources]
    made: list = [by.by] if by else [kind] if kind != features.SIFT else []
    made += ["masks", masks.by] if isinstance(masks, Estimator) else []
    made += ["time", limit] if limit else []
    known = json.dumps([stamps, names, sampling.stated, pycolmap.__version__, MADE, *made])
    return hashlib.sha256(known.encode()).hexdigest()[:16]
