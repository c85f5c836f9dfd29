"""Captures out of videos and photos: frames are placed, and taken denser where that fails."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.model import write_model
from fsel.captures.colmap.runs import SEED, Part, Work, build
from fsel.captures.images import video
from fsel.captures.layouts import bare
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.poses import sfm
from fsel.captures.poses.sfm import DATABASE
from fsel.captures.sampling import IMAGES, SampledFrames, Say, Source, photo_name, take, take_denser
from fsel.core.geometry import upright
from fsel.core.names import natural

MODEL = "sparse/0"
ROUNDS = 2  # of taking frames denser
UNSURE = 3.0  # degrees between two sets of poses: sure ones differ by tenths
MOST_REPEATED = 150  # frames up to which they are found again: the time grows with their square
OTHER = 0.1  # share of the frames by which the sets' numbers differ where they are by chance


def place(
    sources: Sequence[Source], sampling: video.Sampling, folder: Path, work: Work, say: Say
) -> dict:
    """Fill a folder with a COLMAP capture of the sources, and return the content of `poses.json`.

    Frames of a video that show the same as the one before them are left out. Where two frames or
    more of a video in a row could not be placed, frames are taken denser, twice at most, as long
    as that helps. What an interrupted run left in the folder is gone on with.
    """
    taken = take(sources, sampling, folder, work, say)
    model, raw = _placed(sources, taken, folder, work, say)
    twice = repeated(model, work)
    poses = [image.cam_from_world().matrix() for image in model.images.values()]
    turn = pycolmap.Rotation3d(upright(np.array(poses)))  # of a world that COLMAP chose
    model.transform(pycolmap.Sim3d(1.0, turn, np.zeros(3)))
    write_model(model, folder / MODEL)
    return {"by": work.who, "repeated": twice} | _found(sources, taken, raw, model)


def _placed(
    sources: Sequence[Source], taken: SampledFrames, folder: Path, work: Work, say: Say
) -> tuple[pycolmap.Reconstruction, RawCapture]:
    """COLMAP's model, and the frames that it was to place."""
    model, placed = None, set[str]()
    for rounds in itertools.count():
        raw, parts = unplaced(sources, taken, folder)
        before = len(placed)
        try:
            model = sfm.place(raw, replace(work, parts=parts), model)
        except sfm.NotPlaced as error:
            in_vain = rounds == ROUNDS or bool(error.cause)
            if in_vain or not _denser(sources, taken, placed, folder, work):
                raise _refused(sources, error) from error
        else:
            placed = {image.name for image in model.images.values()}
            in_vain = rounds == ROUNDS or len(placed) == before
            if in_vain or not _denser(sources, taken, placed, folder, work):
                break
        say("video", "frames were not placed: taken denser there")
        taken.save(folder)
    return model, raw


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
    usual = f"the {several} show too little in common. Hint: more images that overlap each other"
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
        parts.append(Part(numbers, ordered=source.filmed))
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


def repeated(model: pycolmap.Reconstruction, work: Work) -> dict | None:
    """Frames that COLMAP places with another seed, and degrees that both sets of poses differ by.

    The degrees are None for fewer than two frames of both; all is, where a program placed them, no
    matches are kept, or more than 150 were placed.
    """
    count = model.num_reg_images()
    if work.by is not None or work.folder is None or count > MOST_REPEATED:
        return None
    quiet = replace(work, watch=lambda label: work.watch(f"{label} again"))
    database = work.folder / DATABASE
    found = build(database, work.folder, count, quiet, seed=SEED + 1)
    second = max(found.values(), key=lambda m: m.num_reg_images(), default=None)
    if second is None:
        return {"placed": 0, "degrees": None}
    both = sorted(set(model.reg_image_ids()) & set(second.reg_image_ids()))
    first, other = (
        np.array([m.images[i].cam_from_world().matrix()[:, :3] for i in both])
        for m in (model, second)
    )
    degrees = round(apart(first, other), 2) if len(both) > 1 else None
    return {"placed": second.num_reg_images(), "degrees": degrees}


def apart(first: np.ndarray, other: np.ndarray) -> float:
    """Return the median degrees between turns of frame pairs, of (n, 3, 3) rotations twice."""
    turns = np.einsum("nij,nik->njk", other, first)  # all the same where the sets agree
    cosines = (np.einsum("nij,mij->nm", turns, turns) - 1) / 2
    rows, columns = np.triu_indices(len(turns), 1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosines[rows, columns], -1, 1)))))


def doubt(found: dict) -> str:
    """Return a sentence on poses that are not sure; empty where they are."""
    again = found.get("repeated")
    if not again:
        return ""
    placed = len(found["placed"])
    if abs(again["placed"] - placed) > OTHER * placed:
        said = f"COLMAP places {again['placed']} frames, not {placed}"
    elif again["degrees"] is not None and again["degrees"] > UNSURE:
        said = f"COLMAP's poses differ by {again['degrees']:.0f} degrees"
    else:
        return ""
    return f"the poses may be wrong: with another seed {said}"
