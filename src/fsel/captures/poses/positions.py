"""Positions by satellite, of photos and of drones' videos, and the world in metres they give."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.runs import SEED
from fsel.captures.images import files as image_files
from fsel.captures.sampling import SampledFrames, Source, photo_name

GPS = 0x8825  # EXIF's table of the position
WITHIN = 10.0  # metres that a position may be off, beyond which it counts as wrong
SURE = 4.0  # times the error that positions spread sideways, or they tell neither scale nor north
TIME = re.compile(r"(\d+):(\d\d):(\d\d),(\d{3})\s*-->")
NAMES = ("lat", "lon", "(?:abs_alt|altitude)")
PLACE = [re.compile(rf"\b{name}\w*\s*:\s*(-?\d+\.?\d*)") for name in NAMES]

Position = tuple[float, ...]
"""Degrees of latitude and longitude, metres of altitude."""


def of_photo(file: Path) -> Position | None:
    """Return the position in a photo's EXIF; None where there is none, or no altitude."""
    with image_files.opened(file) as photo:
        try:
            tags = photo.getexif().get_ifd(GPS)
            turns = [sum(float(part) / 60**i for i, part in enumerate(tags[key])) for key in (2, 4)]
            signs = [-1 if tags[key][0] in "SW" else 1 for key in (1, 3)]
            altitude = float(tags[6]) * (-1 if tags.get(5) in (1, b"\x01") else 1)
        except Exception:  # of damaged EXIF all kinds
            return None
    where = (turns[0] * signs[0], turns[1] * signs[1], altitude)
    return where if np.isfinite(where).all() and any(turns) else None


def subtitles(path: Path) -> Path | None:
    """Return the file of subtitles beside a video, as DJI's drones write it."""
    named = (path.with_suffix(ending) for ending in (".SRT", ".srt"))
    return next((file for file in named if file.is_file()), None)


def of_video(path: Path) -> np.ndarray:
    """Return (n, 4) seconds, latitude, longitude and altitude that a video's subtitles say."""
    file, rows = subtitles(path), []
    text = file.read_text(encoding="utf-8", errors="replace") if file else ""
    for block in re.split(r"\n\s*\n", text.replace("\r", "")):
        time, place = TIME.search(block), [name.search(block) for name in PLACE]
        if time and all(place):
            where = [float(found[1]) for found in place if found]
            seconds = np.array(time.groups(), float) @ [3600, 60, 1, 0.001]
            rows += [[seconds, *where]] if any(where[:2]) else []  # zeros without a fix
    return np.array(rows).reshape(-1, 4)


def stated(sources: Sequence[Source], taken: SampledFrames) -> dict[str, Position]:
    """Return the positions of frames by their names in the capture, of those that have one."""
    found = {}
    for source in sources:
        for photo in source.photos:
            if where := of_photo(photo):
                found[source.named(photo_name(photo))] = where
        if source.filmed and len(track := of_video(source.path)):
            for shot in taken.shots[source.name]:
                at = (float(np.interp(shot.seconds, track[:, 0], part)) for part in track.T[1:])
                found[source.named(shot.name)] = tuple(at)
    return found


def align(model: pycolmap.Reconstruction, known: dict[str, Position]) -> dict | None:
    """Bring a model into metres, x east, y north and z up, where positions tell them.

    Returns:
        How many frames have a position, the median metres that they are off, the world's origin,
        and whether the model was moved; None without positions of three frames.
    """
    images = [image for image in model.images.values() if image.name in known]
    if len(images) < 3:
        return None
    places = np.array([known[image.name] for image in images])
    origin = np.median(places, axis=0)
    metres = pycolmap.GPSTransform().ellipsoid_to_enu(places, *origin)
    centers = np.array([image.projection_center() for image in images])
    options = pycolmap.RANSACOptions(max_error=WITHIN, random_seed=SEED)
    found = pycolmap.estimate_sim3d_robust(centers, metres, options)
    report = {"frames": len(images), "metres": None, "origin": origin.tolist(), "used": False}
    if found is None:
        return report
    moved = found["tgt_from_src"] * centers
    off = float(np.median(np.linalg.norm(moved - metres, axis=1)))
    sideways = np.linalg.svd(moved - moved.mean(axis=0), compute_uv=False)[1]
    used = bool(sideways / np.sqrt(len(images)) > SURE * off)
    if used:
        model.transform(found["tgt_from_src"])
    return report | {"metres": round(off, 3), "used": used}


def in_words(gps: dict, frames: int) -> str:
    """Return a sentence on what `align` returned, of so many placed frames."""
    said = f"{gps['frames']} of {frames} placed frames have a position"
    if gps["used"]:
        return f"{said}, {gps['metres']:.2g} m off on the median: metres, x east, y north, z up"
    return f"{said}, too inexact or too close together: the world's scale stays unknown"
