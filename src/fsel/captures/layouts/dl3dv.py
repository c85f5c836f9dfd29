"""DL3DV: nerfstudio files whose intrinsics are at full resolution though only images_4 ship.

The benchmark holds two distributions of a scene, `nerfstudio` (distorted images) and
`gaussian_splat` (COLMAP, undistorted); their poses and cameras do not mix.
"""

from __future__ import annotations

from pathlib import Path

from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.layouts.contract import Layout, RawCapture, Recording

FACTOR = 4
COPIES = ("images_4", "images_8")  # of images in 4K, which take half a second each to open
SPLATS = "gaussian_splat"


def _root(folder: Path) -> Path | None:
    """The folder of transforms.json with downscaled images: the scene's own, or one inside."""
    for root in (folder / "nerfstudio", folder / "colmap", folder):
        small = any((root / name).is_dir() for name in COPIES)
        if (root / "transforms.json").is_file() and small:
            return root
    return None


def recognises(folder: Path) -> bool:
    """Look for downscaled images with transforms.json, or gaussian_splat alone."""
    return _root(folder) is not None or (folder / SPLATS / "sparse" / "0").is_dir()


def read(folder: Path) -> RawCapture:
    """Read either distribution, `nerfstudio` where both ship; points from its colmap/sparse/0."""
    root = _root(folder)
    if root is None and (folder / SPLATS).is_dir():
        return colmap.read(folder / SPLATS)
    if root is None:
        raise FileNotFoundError(
            f"{folder}: no transforms.json with images_4 or images_8, and no {SPLATS}; some scenes "
            "of the release have none: leave this one out"
        )
    raw = nerfstudio.from_json(
        root / "transforms.json", root, undo=nerfstudio.OLD_APPLIED_TRANSFORM, copies=COPIES
    )
    model = root / "colmap" / "sparse" / "0"
    return colmap.with_points(raw, model) if model.is_dir() else raw


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as the benchmark's nerfstudio folder; frames in arbitrary order."""
    root = folder / "nerfstudio"
    names = recording.write_images(root / "images_4", "png")
    camera = colmap.scaled(recording.camera, FACTOR)
    nerfstudio.write_scene(recording, camera, names, nerfstudio.OLD_APPLIED_TRANSFORM, root)
    colmap.write_sparse(recording, camera, names, root / "colmap" / "sparse" / "0")


LAYOUT = Layout("dl3dv", recognises, read, write)
