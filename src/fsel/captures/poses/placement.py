"""Captures out of videos and photos: frames are placed, and taken denser where that fails."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.mapping import Mapped
from fsel.captures.colmap.model import enlarge, write_model
from fsel.captures.colmap.runs import Part, Work
from fsel.captures.images import video
from fsel.captures.images.files import size_of
from fsel.captures.layouts import bare
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.poses import panoramas, positions, sfm
from fsel.captures.quality.poses import turned_away
from fsel.captures.sampling import IMAGES, SampledFrames, Say, Source, photo_name, take, take_denser
from fsel.core.geometry import upright
from fsel.core.names import natural
from fsel.core.wording import counted

MODEL = "sparse/0"
ROUNDS = 2  # of taking frames denser
UNSURE = 3.0  # degrees between two sets of poses: sure ones differ by tenths
FEW = 0.5  # share of the frames, fewer of which another mapper places where they are by chance
SHOWN = 8  # names, or times
STOPPED = "; the search ended in time. Hint: --pose-time 10m looks longer"
KEPT = 0.9  # share of the frames that are still placed where a path is mended


def place(
    sources: Sequence[Source], sampling: video.Sampling, folder: Path, work: Work, say: Say
) -> dict:
    """Fill a folder with a COLMAP capture of the sources, and return the content of `poses.json`.

    Frames of a video that show the same as the one before them are left out. Where two frames or
    more of a video in a row could not be placed, frames are taken denser, twice at most, as long
    as that helps and there is time. Where the path jumps, the frames are placed once more without
    the matches that may have folded it. What an interrupted run left in the folder is gone on with.
    """
    around, work = sources[0].panoramic, replace(work, say=say)
    whole = folder.with_name("panoramas") if around else folder
    taken = take(sources, sampling, whole, work, say)
    mapped, raw = _placed(sources, taken, whole, work, say)
    mapped = _mended(sources, taken, whole, work, mapped)
    model, jumps = mapped.model, _jumps(sources, taken, mapped.model)
    if work.by is None:  # programs see the frames as they are
        enlarge(model, lambda name: size_of(whole / IMAGES / name))
    poses = [image.cam_from_world().matrix() for image in model.images.values()]
    turn = pycolmap.Rotation3d(upright(np.array(poses)))  # of a world that COLMAP chose
    model.transform(pycolmap.Sim3d(1.0, turn, np.zeros(3)))
    gps = positions.align(model, positions.stated(sources, taken))
    found: dict = {"by": work.who, "mapper": mapped.by, "other": compared(mapped), "jumps": jumps}
    found |= {"gps": gps, "stopped": work.time.left <= 0} | _found(sources, taken, raw, model)
    if around:
        found["views"] = list(panoramas.VIEWS)
        model = panoramas.cut(model, whole / IMAGES, folder / IMAGES, work.watch("views"))
        shutil.rmtree(whole)
    write_model(model, folder / MODEL)
    return found


def _placed(
    sources: Sequence[Source], taken: SampledFrames, folder: Path, work: Work, say: Say
) -> tuple[Mapped, RawCapture]:
    """COLMAP's model, and the frames that it was to place: the best of several tries."""
    best: tuple[Mapped, RawCapture, dict] | None = None
    for tries_left in reversed(range(ROUNDS + 1)):
        raw, parts = unplaced(sources, taken, folder)
        placed, error = set[str](), None
        try:
            mapped = sfm.place(raw, replace(work, parts=parts), best and best[0].model)
        except sfm.NotPlaced as why:
            error = why
            if best is not None or why.cause:
                break
        else:
            placed = {image.name for image in mapped.model.images.values()}
            if best is not None and len(placed) <= best[0].model.num_reg_images():
                break  # denser frames were placed no better
            best = mapped, raw, {name: list(shots) for name, shots in taken.shots.items()}
        in_time = tries_left and work.time.left > 0
        if not in_time or not _denser(sources, taken, placed, folder, work):
            break
        say("video", "frames were not placed: sampling more densely there")
        taken.save(folder)
    if best is None:
        assert error is not None
        raise _refused(sources, error) from error
    taken.shots = best[2]
    return best[0], best[1]


def _mended(
    sources: Sequence[Source], taken: SampledFrames, folder: Path, work: Work, mapped: Mapped
) -> Mapped:
    """The same where the path does not jump; else placed once more, without the far matches
    across the jumps that may have folded it, and kept where it jumps less."""
    jumps = _jumps(sources, taken, mapped.model)
    if not jumps or work.by is not None or work.time.left <= 0:
        return mapped
    raw, parts = unplaced(sources, taken, folder)
    breaks = sorted(raw.names.index(jump["name"]) for jump in jumps)
    try:
        again = sfm.place(raw, replace(work, parts=parts, breaks=breaks))
    except sfm.NotPlaced:
        return mapped
    enough = again.model.num_reg_images() >= KEPT * mapped.model.num_reg_images()
    return again if enough and len(_jumps(sources, taken, again.model)) < len(jumps) else mapped


def _jumps(
    sources: Sequence[Source], taken: SampledFrames, model: pycolmap.Reconstruction
) -> list[dict]:
    """Frames of videos that are turned away from the one before them, with their seconds."""
    found = []
    poses = {image.name: image.cam_from_world().matrix() for image in model.images.values()}
    for source in sources:
        shots = [s for s in taken.shots.get(source.name, ()) if source.named(s.name) in poses]
        names = [source.named(shot.name) for shot in shots]
        seconds = np.array([shot.seconds for shot in shots])
        turns = turned_away(np.array([poses[name] for name in names]).reshape(-1, 3, 4), seconds)
        for at in np.flatnonzero(turns).tolist():
            times = {"from": seconds[at - 1], "to": seconds[at]}
            jump = {"video": source.path.name, "name": names[at], "degrees": round(turns[at])}
            found.append(jump | times)
    return found


def _denser(
    sources: Sequence[Source], taken: SampledFrames, placed: set[str], folder: Path, work: Work
) -> bool:
    """Take more frames where two or more in a row were not placed; false where there are none."""
    more = False
    for source in sources:
        spans = _lost(source, taken, placed)
        lost = [(low, high) for low, high, count in spans if count > 1]
        more |= bool(lost) and take_denser(source, taken, lost, folder, work)
    return more


def _refused(sources: Sequence[Source], error: sfm.NotPlaced) -> ValueError:
    several = "videos" if any(source.filmed for source in sources) else "photos"
    usual = f"the {several} have too little in common. Hint: take more images that overlap"
    if several == "videos":
        usual += ", as of a slower walk"
    paths = ", ".join(str(source.path) for source in sources)
    return ValueError(f"{paths}: {error.said}: {error.cause or usual}")


def unplaced(
    sources: Sequence[Source], taken: SampledFrames, folder: Path
) -> tuple[RawCapture, list[Part]]:
    """Return frames without poses, source after source, and the part of each source for COLMAP."""
    names, parts = [], []
    for source in sources:
        shots = taken.shots.get(source.name, ())
        numbers = [shot.index for shot in shots] or range(len(source.photos))
        files = [shot.name for shot in shots] or [photo_name(photo) for photo in source.photos]
        parts.append(Part(numbers, ordered=source.filmed, panoramic=source.panoramic))
        names += [source.named(name) for name in files]
    return bare.of_files(names, [folder / IMAGES / name for name in names]), parts


def _lost(source: Source, taken: SampledFrames, placed: set[str]) -> list[tuple[float, float, int]]:
    """Seconds from one placed frame to the next, or to an end, with the frames lost between."""
    spans, start, count = [], taken.start, 0
    shots = taken.shots.get(source.name, [])
    for shot in shots:
        if source.named(shot.name) not in placed:
            count += 1
            continue
        if count:
            spans.append((start, shot.seconds, count))
        start, count = shot.seconds, 0
    if count:  # what is like the last frame is lost with it
        spans.append((start, taken.ends.get(source.name, shots[-1].seconds), count))
    return spans


def _found(
    sources: Sequence[Source], taken: SampledFrames, raw: RawCapture, model: pycolmap.Reconstruction
) -> dict:
    """Return the content of `poses.json`."""
    placed = {image.name for image in model.images.values()}
    shots, lost = [], []
    for source in sources:
        for shot in taken.shots.get(source.name, ()):
            shots.append({"name": source.named(shot.name)} | asdict(shot))
        for low, high, count in _lost(source, taken, placed):
            lost.append({"video": source.path.name, "from": low, "to": high, "frames": count})
    ordered = sorted(raw.names, key=natural)
    return {
        "video": shots,
        "turned": taken.turned,
        "still": taken.still,
        "frames": len(raw.names),
        "placed": [name for name in ordered if name in placed],
        "not_placed": [name for name in ordered if name not in placed],
        "lost": lost,
    }


def compared(mapped: Mapped) -> dict | None:
    """Frames that the other mapper places, and degrees that both sets of poses differ by, None for
    fewer than two frames of both; None where it was not asked."""
    first, second = mapped.model, mapped.other
    if second is None:
        return None
    both = sorted(set(first.reg_image_ids()) & set(second.reg_image_ids()))
    turns = [
        np.array([m.images[i].cam_from_world().matrix()[:, :3] for i in both])
        for m in (first, second)
    ]
    degrees = round(apart(*turns), 2) if len(both) > 1 else None
    return {"placed": second.num_reg_images(), "degrees": degrees}


def apart(first: np.ndarray, other: np.ndarray) -> float:
    """Return the median degrees between turns of frame pairs, of (n, 3, 3) rotations twice."""
    turns = np.einsum("nij,nik->njk", other, first)  # all the same where the sets agree
    cosines = (np.einsum("nij,mij->nm", turns, turns) - 1) / 2
    rows, columns = np.triu_indices(len(turns), 1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosines[rows, columns], -1, 1)))))


def doubts(found: dict) -> list[str]:
    """Return sentences on poses that are not sure."""
    said, other, placed = [], found.get("other"), len(found["placed"])
    if other and other["placed"] < FEW * placed:
        differ = f"one places {other['placed']} frames, the other {placed}"
    else:
        degrees = (other and other["degrees"]) or 0
        differ = f"their poses differ by {degrees:.0f} degrees" if degrees > UNSURE else ""
    if differ:
        said.append(f"the poses may be wrong: COLMAP's two mappers disagree, {differ}")
    if jumps := found.get("jumps"):
        times = ", ".join(f"{jump['from']:.1f} to {jump['to']:.1f} s" for jump in jumps)
        turn = max(jump["degrees"] for jump in jumps)
        alike = "the scene may look alike from two sides"
        said.append(f"the path jumps, by up to {turn} degrees: {times}; {alike}")
    return said


def notes(found: dict | None) -> list[str]:
    """Frames that were not placed, the longest times that none shows, and doubts, in words."""
    if not found:
        return []
    unsure = doubts(found)
    missing, lost = found["not_placed"], found["lost"]
    said = f"{counted(len(missing), 'frame')} not placed: {first_of(missing)}"
    said += STOPPED if found.get("stopped") else ""
    if not lost:
        return [said, *unsure] if missing else unsure
    longest = sorted(lost, key=lambda span: span["from"] - span["to"])[:SHOWN]
    films = len({span["video"] for span in lost})
    times = ", ".join(
        f"{span['from']:.1f} to {span['to']:.1f} s" + (f" of {span['video']}" if films > 1 else "")
        for span in sorted(longest, key=lambda span: (span["video"], span["from"]))
    )
    return [f"{said}; lost: {times}", *unsure]


def first_of(names: list[str]) -> str:
    """Name the first ones, and say how many more there are."""
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
