"""7-Scenes: several passes of one room, a text pose beside every image, no sparse points."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import Layout, RawCapture, Recording, has_file
from fsel.captures.parsing import check_turn, numbers, read_matrix, read_text
from fsel.core.geometry import invert_pose

SIZE = (640, 480)
DEPTH_FOCAL = 585.0  # of the depth camera, whose poses the dataset gives
COLOR_FOCAL = 525.0  # of the colour camera; a common value, the dataset states none
NO_DEPTH = 65535
DEPTH_TO_COLOR = np.array(
    [
        [9.9996518012567637e-01, 2.6765126468950343e-03, -7.9041012313000904e-03, -0.025558943178],
        [-2.7409311281316700e-03, 9.9996302803027592e-01, -8.1504520778013286e-03, 1.010963627e-04],
        [7.8819942130445332e-03, 8.1718328771890631e-03, 9.9993554558014031e-01, 2.0318321729e-03],
    ]
)
"""Rigid motion, metres, from the depth to the colour camera of a Kinect, as calibrated by LIRIS
(projet.liris.cnrs.fr/voir/activities-dataset/kinect-calibration.html) and used by ACE and DSAC*."""
POSE_SOURCES = ("original", "calibrated", "pgt")


def read(folder: Path, pose_source: str = "original") -> RawCapture:
    """Read all passes that TrainSplit.txt and TestSplit.txt name, without frames of lost poses.

    `pose_source` is `original`, the depth camera's poses and focal length; `calibrated`, moved to
    the colour camera; or `pgt`, of Brachmann et al. (ICCV 2021) in pgt_{train,test}.txt.
    """
    if pose_source not in POSE_SOURCES:
        raise ValueError(f"pose_source is {pose_source!r}; allowed: {', '.join(POSE_SOURCES)}")
    known = _pgt(folder) if pose_source == "pgt" else {}
    names, files, poses, cameras, dropped = [], [], [], [], {}
    for sequence in _sequences(folder):
        for image in sorted((folder / sequence).glob("*.color.png")):
            stem = image.name.removesuffix(".color.png")
            name = f"{sequence}/{stem}"
            if pose_source == "pgt":
                pose, focal = known.get(name, (np.full((3, 4), np.nan), COLOR_FOCAL))
            else:
                pose = invert_pose(read_matrix(folder / sequence / f"{stem}.pose.txt"))
                focal = DEPTH_FOCAL
            if pose_source == "calibrated":
                pose, focal = DEPTH_TO_COLOR @ np.vstack([pose, [0, 0, 0, 1]]), COLOR_FOCAL
            if not np.isfinite(pose).all():
                dropped[name] = "tracking lost (pose not finite or not there)"
                continue
            names.append(name)
            files.append(image)
            poses.append(pose)
            cameras.append(Camera("PINHOLE", *SIZE, (focal, focal, SIZE[0] / 2, SIZE[1] / 2)))
    if not names:
        raise ValueError(f"{folder}: no frames with poses in {_sequences(folder)}")
    return RawCapture(
        names=names,
        images=files,
        world_to_camera=np.array(poses),
        cameras=cameras,
        sequences=[name.split("/")[0] for name in names],
        dropped=dropped,
    )


def _sequences(folder: Path) -> list[str]:
    """Return the folders of the passes that the split files name: `sequence3` is seq-03."""
    passes = []
    for split in ("TrainSplit.txt", "TestSplit.txt"):
        for line in read_text(folder / split).split():
            number = line.removeprefix("sequence")
            if not number.isdecimal():
                raise ValueError(f"{folder / split}: expected lines like sequence3, got {line!r}")
            passes.append(int(number))
    names = [f"seq-{number:02d}" for number in sorted(set(passes))]
    for name in names:
        if not (folder / name).is_dir():
            raise FileNotFoundError(
                f"{folder / name}: named by a split file but not there; the sequences are "
                "archives inside the scene's archive and must be unpacked too"
            )
    return names


def _pgt(folder: Path) -> dict[str, tuple[np.ndarray, float]]:
    """Frame name -> world-to-camera and focal length: `file qw qx qy qz tx ty tz f` a line."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    frames = {}
    for split in ("train", "test"):
        path = folder / f"pgt_{split}.txt"
        if not path.is_file():
            raise FileNotFoundError(
                f"{path}: missing; copy 7scenes_{folder.name}_{split}.txt of the repository "
                "tsattler/visloc_pseudo_gt_limitations there"
            )
        for at, line in enumerate(read_text(path).splitlines(), start=1):
            file, *words = line.split() or [""]
            w, x, y, z, *rest = numbers(words, (8,), path, f"what follows the name in line {at}")
            check_turn([x, y, z, w], path, f"line {at}")
            rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
            pose = np.column_stack([rotation, rest[:3]])
            name = "/".join(Path(file).parts[-2:]).removesuffix(".color.png")
            frames[name] = (pose, rest[3])
    return frames


def write(recording: Recording, folder: Path) -> None:
    """Write a recording with millimetre depth; the last pass is the test split."""
    recording.write_images(folder, "color.png")
    depth = np.where(recording.depth > 0, recording.depth * 1000, NO_DEPTH)
    depth = np.clip(np.rint(depth), 0, NO_DEPTH).astype(np.uint16)
    image_files.write(depth, folder, [f"{name}.depth.png" for name in recording.names])
    for name, pose in zip(recording.names, recording.world_to_camera, strict=True):
        full = np.vstack([invert_pose(pose), [0, 0, 0, 1]])
        np.savetxt(folder / f"{name}.pose.txt", full, fmt="%.17g")
    passes = sorted({int(label.removeprefix("seq-")) for label in recording.sequences})
    lines = [f"sequence{number}\n" for number in passes]
    (folder / "TrainSplit.txt").write_text("".join(lines[:-1]))
    (folder / "TestSplit.txt").write_text(lines[-1])


LAYOUT = Layout("seven_scenes", has_file("TrainSplit.txt"), read, write, ("pose_source",))
