"""DL3DV: nerfstudio files whose intrinsics are at full resolution though only images_4 ship.

The benchmark holds two distributions of a scene, `nerfstudio` (distorted images) and
`gaussian_splat` (COLMAP, undistorted); their poses and cameras do not mix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.layouts.contract import Layout, RawCapture, Recording
from fsel.captures.parsing import read_json, read_json_list, text
from fsel.core.problem import Method, Problem

FACTOR = 4
COPIES = ("images_4", "images_8")  # of images in 4K, which take half a second each to open
SPLATS = "gaussian_splat"
EVERY = 8  # of the protocol: every eighth frame is held out
LISTED, LISTED_LABEL = "listed", "Long-LRM's list"


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


def frame_order(folder: Path) -> list[str]:
    """Return the names of the images in the order of a scene's transforms.json."""
    root = _root(folder) or folder
    content = read_json(root / "transforms.json")
    return [Path(frame["file_path"]).name for frame in content["frames"]]


def write(recording: Recording, folder: Path) -> None:
    """Write a recording as the benchmark's nerfstudio folder; frames in arbitrary order."""
    root = folder / "nerfstudio"
    names = recording.write_images(root / "images_4", "png")
    camera = colmap.scaled(recording.camera, FACTOR)
    nerfstudio.write_scene(recording, camera, names, nerfstudio.OLD_APPLIED_TRANSFORM, root)
    colmap.write_sparse(recording, camera, names, root / "colmap" / "sparse" / "0")


@dataclass(frozen=True)
class Protocol:
    """Frames of one scene, by their numbers in a capture."""

    targets: np.ndarray  # (T,) int64, ascending
    inputs: dict[int, np.ndarray]  # number of frames -> (k,) int64 distinct frames, ascending

    @property
    def method(self) -> Method:
        """The listed frames as a method, for the numbers of frames that are listed."""

        def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
            return self.inputs[k]

        return Method(LISTED, LISTED_LABEL, "observed", nested=False, select=select)


def read_protocol(
    file: str | Path, scene: str, folder: str | Path, names: Sequence[str]
) -> Protocol:
    """Return one scene's protocol of Long-LRM's evaluation (Ziwen et al. 2025), every eighth frame
    held out, from the authors' `dl3dv_fold_8_kmeans_input_idx.json`; ValueError where it does not
    fit."""
    file, folder = Path(file), Path(folder)
    entries = {text(entry, "scene_name", file): entry for entry in read_json_list(file)}
    if scene not in entries:
        raise ValueError(f"{file}: no scene {scene} among its {len(entries)}")
    order = [PurePosixPath(name).stem for name in frame_order(folder)]
    rows = {PurePosixPath(name).stem: row for row, name in enumerate(names)}
    targets = _rows(range(0, len(order), EVERY), order, rows, f"{folder}: held-out frames")
    inputs = {}
    for key, places in entries[scene].items():
        if key.startswith(f"fold_{EVERY}_kmeans_") and key.endswith("_input"):
            found = _rows(places, order, rows, f"{file}: {scene}, {key}")
            if both := np.intersect1d(found, targets).tolist():
                raise ValueError(f"{file}: {scene}, {key}: frames {both} are held out")
            inputs[len(found)] = found
    return Protocol(targets, inputs)


def _rows(
    places: Sequence[int], order: Sequence[str], rows: dict[str, int], where: str
) -> np.ndarray:
    """Return (n,) int64 ascending rows of the capture at some places of transforms.json."""
    if wrong := [place for place in places if not 0 <= place < len(order)]:
        raise ValueError(f"{where}: places {wrong}; allowed: 0 to {len(order) - 1}")
    if missing := [order[place] for place in places if order[place] not in rows]:
        raise ValueError(f"{where}: {missing} are not among the capture's {len(rows)} frames")
    return np.unique([rows[order[place]] for place in places]).astype(np.int64)


LAYOUT = Layout("dl3dv", recognises, read, write)
