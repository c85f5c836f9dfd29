"""A folder of images and nothing else: poses come from COLMAP or from another estimator's file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.images import files as image_files
from fsel.captures.images import video
from fsel.captures.layouts.contract import Layout, RawCapture
from fsel.core.names import natural
from fsel.core.wording import counted

ENDINGS = (".jpg", ".jpeg", ".png")
FOLDERS = ("images", "input", ".")
RAW = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".raf", ".rw2")
RAW_HINT = ". Hint: develop RAW photos to JPEG first, as with RawTherapee or darktable-cli"


def find(folder: Path, endings: tuple[str, ...] = ENDINGS) -> list[Path]:
    """Return the image files of the first of images/, input/ and the folder itself that has any."""
    for name in FOLDERS:
        inside = (folder / name).glob("*")
        files = [path for path in inside if path.suffix.lower() in endings and path.is_file()]
        if files:
            return sorted(files, key=lambda path: natural(path.name))
    return []


def explained(path: Path) -> str:
    """Return what to do with a path that holds no capture, as the end of a refusal."""
    if path.suffix.lower() in video.DUAL:
        return "; it is of a 360-degree camera. Hint: export a 2:1 .mp4 in its own program"
    if not path.is_dir():
        return ""
    if not any(path.iterdir()):
        return "; the folder is empty"
    if find(path, (*ENDINGS, *image_files.HEIC)):
        return "; its images have no poses. Hint: `poses=colmap` finds them"
    if films := find(path, video.ENDINGS):
        return f"; it has videos. Hint: name them, such as {films[0]}"
    raw = find(path, RAW)
    return f"; it has {counted(len(raw), 'RAW photo')}{RAW_HINT}" if raw else ""


def read(folder: Path) -> RawCapture:
    """Return names and files; poses are not finite and the focal length a guess until placed."""
    files = find(folder)
    if not files:
        raise FileNotFoundError(f"{folder}: no images in it, in images or in input")
    return of_files([file.name for file in files], files)


def of_files(names: list[str], files: list[Path]) -> RawCapture:
    """Return the same of some images by their names."""
    return RawCapture(
        names=names,
        images=files,
        world_to_camera=np.full((len(files), 3, 4), np.nan),
        cameras=[guess(image_files.size_of(files[0]))] * len(files),
        sequences=["capture"] * len(files),
    )


def guess(size: tuple[int, int]) -> Camera:
    """Return a camera of (width, height) pixels whose focal length is the longer side."""
    return Camera("SIMPLE_PINHOLE", *size, (max(size), size[0] / 2, size[1] / 2))


LAYOUT = Layout("images", lambda folder: False, read)
"""Never recognised: without poses there is nothing to select, so the layout must be named."""
