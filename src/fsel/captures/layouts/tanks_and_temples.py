"""Tanks and Temples: the 3DGS release, the official one with its .log of poses, and NeRF++'s."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import HALF
from fsel.captures.images import files as image_files
from fsel.captures.images.matching import choose_pairs, focal_from_poses, match
from fsel.captures.layouts import bare, colmap
from fsel.captures.layouts.contract import Layout, RawCapture, Recording, one_pass
from fsel.captures.parsing import numbers, read_matrix, read_text
from fsel.core.geometry import invert_pose

FACTOR = 2
PAIRS = 12
SPLITS = ("train", "test")  # of NeRF++; its validation repeats test, its camera_path has no images


def recognises(folder: Path) -> bool:
    """Look for a .log of poses, or NeRF++'s folders; the 3DGS release is plain COLMAP."""
    return _log_file(folder) is not None or (folder / "train" / "intrinsics").is_dir()


def read(folder: Path, focal: float | None = None) -> RawCapture:
    """Read whichever release lies there; `focal` is the focal length over the image width, which
    the official release does not state: by default it is found by matching frames."""
    if (folder / "train" / "intrinsics").is_dir():
        return _read_nerfpp(folder)
    path = _log_file(folder)
    if path is None:
        return colmap.read(folder)
    files, poses, dropped = _read_log(path, bare.find(folder))
    width, height = image_files.size_of(files[0])
    f = width * focal if focal else _estimated(files, poses, path)
    camera = Camera("SIMPLE_PINHOLE", width, height, (f, width / 2, height / 2))
    return one_pass(
        [(file, pose, camera) for file, pose in zip(files, poses, strict=True)], dropped
    )


def _log_file(folder: Path) -> Path | None:
    """<Scene>_COLMAP_SfM.log in the scene's folder, or beside it."""
    places = [
        *sorted(folder.glob("*_COLMAP_SfM.log")),
        folder.parent / f"{folder.name}_COLMAP_SfM.log",
    ]
    return next((path for path in places if path.is_file()), None)


def _read_log(path: Path, files: list[Path]) -> tuple[list[Path], np.ndarray, dict[str, str]]:
    """Entries `k m 0` and a 4x4 camera-to-world; k counts the images, m = -1: not registered."""
    words = read_text(path).split()
    if not words or len(words) % 19:
        raise ValueError(f"{path}: {len(words)} numbers, expected 19 per entry (k m 0 and 4x4)")
    entries = numbers(words, (len(words),), path, "the log").reshape(-1, 19)
    counted = np.array_equal(entries[:, 0], np.arange(len(entries)))
    if not counted or len(entries) > len(files):
        raise ValueError(
            f"{path}: {len(entries)} poses for {len(files)} images; poses count the images 0, 1, "
            "2, ... in sorted order, so none may be missing (Church is known to come with fewer)"
        )
    used = entries[entries[:, 1] >= 0]
    lost = entries[entries[:, 1] < 0, 0].astype(int)
    dropped = {files[k].name: "not registered" for k in lost}
    poses = np.array([invert_pose(entry.reshape(4, 4)) for entry in used[:, 3:]])
    return [files[k] for k in used[:, 0].astype(int)], poses, dropped


def _estimated(files: list[Path], poses: np.ndarray, path: Path) -> float:
    """Return the focal length in pixels from matches of some pairs."""
    matches, size = [], (0, 0)
    for i, j in choose_pairs(poses, PAIRS):
        first, second = image_files.load(files[i]), image_files.load(files[j])
        size = first.shape[1::-1]
        xa, xb = match(first, second)
        if len(xa):
            matches.append((xa, xb, poses[i], poses[j]))
    if not matches:
        raise ValueError(
            f"{path}: the release states no focal length and no pair of frames matches; give "
            "`reading: {focal: focal length over image width}`"
        )
    return focal_from_poses(matches, size)


def _read_nerfpp(folder: Path) -> RawCapture:
    """Folders train and test of rgb, pose (camera to world) and intrinsics, 16 numbers each."""
    files = [f for split in SPLITS for f in sorted((folder / split / "rgb").glob("*"))]
    if not files:
        raise FileNotFoundError(f"{folder}: no images in train/rgb or test/rgb")
    frames = []
    for file in files:
        of_split, name = file.parents[1], f"{file.stem}.txt"
        pose = invert_pose(read_matrix(of_split / "pose" / name))
        k = read_matrix(of_split / "intrinsics" / name)
        params = (k[0, 0], k[1, 1], k[0, 2] + HALF, k[1, 2] + HALF)
        frames.append((file, pose, Camera("PINHOLE", *image_files.size_of(file), params)))
    return one_pass(frames, {})


def write(recording: Recording, folder: Path) -> None:
    """Write images/ at half size, and sparse/0 without frames whose pose was lost."""
    names = recording.write_images(folder / "images", "jpg")
    camera = colmap.scaled(recording.camera, FACTOR)
    colmap.write_sparse(recording, camera, names, folder / "sparse" / "0", lost=False)


LAYOUT = Layout("tanks_and_temples", recognises, read, write, ("focal",))
"""The 3DGS release is recognised as plain COLMAP, whose reader serves it."""
