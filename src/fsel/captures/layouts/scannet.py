"""ScanNet v2, exported from .sens: unpadded names, lost poses of -inf, masks of instances."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import HALF
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import Layout, RawCapture, Recording
from fsel.captures.parsing import read_matrix
from fsel.core.geometry import invert_pose

ORTHONORMAL = 1e-3


def recognises(folder: Path) -> bool:
    """Look for intrinsic/ and pose/ beside color/, in the scene's folder or an export inside it."""
    return (_root(folder) / "intrinsic" / "intrinsic_color.txt").is_file()


def _root(folder: Path) -> Path:
    """Return the folder of the export."""
    inner = sorted(path.parent for path in folder.glob("*/color") if path.is_dir())
    return folder if (folder / "color").is_dir() or not inner else inner[0]


def read(folder: Path, instance: int | None = None) -> RawCapture:
    """Read every colour frame that has a pose; the pixels of `instance`, a value in
    instance-filt/*.png, become the capture's masks."""
    root = _root(folder)
    files = {file.stem: file for file in (root / "color").glob("*.jpg")}
    if not files:
        raise FileNotFoundError(
            f"{root / 'color'}: no frames; export the scene's .sens file with the dataset's "
            "SensReader (color, pose and intrinsic)"
        )
    stems = sorted(files, key=int)
    poses = {stem: read_matrix(root / "pose" / f"{stem}.txt") for stem in stems}
    # lost ones are -inf, some NaN
    turns = {stem: pose[:3, :3] for stem, pose in poses.items() if np.isfinite(pose).all()}
    kept = [stem for stem, turn in turns.items() if abs(np.linalg.det(turn) - 1) < ORTHONORMAL]
    if not kept:
        raise ValueError(f"{root / 'pose'}: no frame has a finite pose")
    k = read_matrix(root / "intrinsic" / "intrinsic_color.txt")
    # the export's pixel centres are at whole numbers
    params = (k[0, 0], k[1, 1], k[0, 2] + HALF, k[1, 2] + HALF)
    camera = Camera("PINHOLE", *image_files.size_of(files[kept[0]]), params)
    return RawCapture(
        names=kept,
        images=[files[stem] for stem in kept],
        world_to_camera=np.array([invert_pose(poses[stem]) for stem in kept]),
        cameras=[camera] * len(kept),
        sequences=["capture"] * len(kept),
        masks=_masks(folder, kept) if instance is not None else None,
        mask_values=(instance, instance) if instance is not None else (1, 255),
        dropped=dict.fromkeys(sorted(poses.keys() - set(kept)), "tracking lost"),
    )


def _masks(folder: Path, stems: list[str]) -> list[Path]:
    places = [folder / "instance-filt", *sorted(folder.glob("*/instance-filt"))]
    masks = next((path for path in places if path.is_dir()), None)
    if masks is None:
        raise FileNotFoundError(
            f"{folder}: no instance-filt; unpack the scene's *_2d-instance-filt.zip there (test "
            "scenes have none)"
        )
    return [masks / f"{stem}.png" for stem in stems]


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as an export, poses of lost frames -inf; objects keep their numbers."""
    count = len(recording.names)
    names = [f"{i}.png" for i in range(count)]
    image_files.write(recording.images, folder / "color", [f"{i}.jpg" for i in range(count)])
    depth = np.rint(np.maximum(recording.depth, 0) * 1000).clip(0, 65535).astype(np.uint16)
    image_files.write(depth, folder / "depth", names)
    if recording.objects is not None:
        image_files.write(recording.objects, folder / "instance-filt", names)
    for name in ("pose", "intrinsic"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for i, pose in enumerate(recording.world_to_camera):
        full = np.vstack([invert_pose(pose), [0, 0, 0, 1]])
        full = np.full((4, 4), -np.inf) if recording.lost[i] else full
        np.savetxt(folder / "pose" / f"{i}.txt", full, fmt="%.17g")
    fx, fy, cx, cy = recording.camera.params
    matrix = np.eye(4)
    matrix[:2, :3] = [[fx, 0, cx - HALF], [0, fy, cy - HALF]]
    for kind in ("color", "depth"):
        np.savetxt(folder / "intrinsic" / f"intrinsic_{kind}.txt", matrix, fmt="%.17g")
        np.savetxt(folder / "intrinsic" / f"extrinsic_{kind}.txt", np.eye(4), fmt="%g")


LAYOUT = Layout("scannet", recognises, read, write, ("instance",))
