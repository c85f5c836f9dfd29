"""Mip-NeRF 360: COLMAP at full resolution, images in folders by factor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fsel.captures.layouts import colmap
from fsel.captures.layouts.contract import Layout, RawCapture, Recording

FACTOR = 4
COPIES = ("images_4", "images_2", "images")


def recognises(folder: Path) -> bool:
    """Look for sparse/0 beside images_4 or images_2."""
    small = (folder / "images_4").is_dir() or (folder / "images_2").is_dir()
    return small and (folder / "sparse" / "0").is_dir()


def read(folder: Path) -> RawCapture:
    """Read the smallest copy that ships of images_4, images_2, images; copies named otherwise than
    `images`, whose names the model has, are paired with them in sorted order."""
    model = folder / "sparse" / "0"
    small = next((folder / name for name in COPIES if (folder / name).is_dir()), None)
    if small is None:
        raise FileNotFoundError(f"{folder}: none of {', '.join(COPIES)} is there")
    reconstruction = colmap.load_model(model)
    full, copies = _files(folder / "images"), _files(small)
    if len(full) == len(copies) and {f.stem for f in full} != {c.stem for c in copies}:
        renamed = dict(zip((file.name for file in full), copies, strict=True))
        raw = colmap.from_model(reconstruction, folder / "images", model)
        return replace(raw, images=[renamed[name] for name in raw.names])
    return colmap.from_model(reconstruction, small, model)


def _files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.glob("*") if file.is_file())


def write(recording: Recording, folder: Path) -> None:
    """Write images_4 and sparse/0, whose camera is four times as large."""
    names = recording.write_images(folder / "images_4", "jpg")
    camera = colmap.scaled(recording.camera, FACTOR)
    colmap.write_sparse(recording, camera, names, folder / "sparse" / "0")


LAYOUT = Layout("mipnerf360", recognises, read, write)
