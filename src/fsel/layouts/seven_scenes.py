"""7-Scenes: several passes of one room, a text pose beside every image, no sparse points."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.layouts import images
from fsel.layouts.base import Layout, RawCapture, invert_pose
from fsel.recording import Camera, Recording

SIZE = (640, 480)
FOCAL = 585.0  # of the depth camera, whose poses the dataset gives
NO_DEPTH = 65535


def read(folder: Path) -> RawCapture:
    """All passes that TrainSplit.txt and TestSplit.txt name; frames with lost poses left out."""
    names, files, poses, dropped = [], [], [], {}
    for sequence in _sequences(folder):
        for image in sorted((folder / sequence).glob("*.color.png")):
            stem = image.name.removesuffix(".color.png")
            pose = _pose(folder / sequence / f"{stem}.pose.txt")
            if not np.isfinite(pose).all():
                dropped[f"{sequence}/{stem}"] = "tracking lost (pose not finite)"
                continue
            names.append(f"{sequence}/{stem}")
            files.append(image)
            poses.append(invert_pose(pose))
    if not names:
        raise ValueError(f"{folder}: no frames with poses in {_sequences(folder)}")
    camera = Camera("PINHOLE", *SIZE, (FOCAL, FOCAL, SIZE[0] / 2, SIZE[1] / 2))
    return RawCapture(
        names=names,
        images=files,
        world_to_camera=np.array(poses),
        cameras=[camera] * len(names),
        sequences=[name.split("/")[0] for name in names],
        dropped=dropped,
    )


def _sequences(folder: Path) -> list[str]:
    """`sequence3` in the split files is the folder seq-03."""
    numbers = []
    for split in ("TrainSplit.txt", "TestSplit.txt"):
        path = folder / split
        if not path.is_file():
            raise FileNotFoundError(f"{path}: split file is missing")
        numbers += [int(line.removeprefix("sequence")) for line in path.read_text().split()]
    return [f"seq-{number:02d}" for number in sorted(numbers)]


def _pose(path: Path) -> np.ndarray:
    pose = np.loadtxt(path, ndmin=2)
    if pose.shape != (4, 4):
        raise ValueError(f"{path}: expected a 4x4 pose, got {pose.shape}")
    return pose


def write(recording: Recording, folder: Path) -> None:
    """Write a recording with millimetre depth; the last pass is the test split."""
    images.write(recording.images, folder, [f"{name}.color.png" for name in recording.names])
    depth = np.where(recording.depth > 0, recording.depth * 1000, NO_DEPTH)
    depth = np.clip(np.rint(depth), 0, NO_DEPTH).astype(np.uint16)
    images.write(depth, folder, [f"{name}.depth.png" for name in recording.names])
    for name, pose in zip(recording.names, recording.world_to_camera, strict=True):
        full = np.vstack([invert_pose(pose), [0, 0, 0, 1]])
        np.savetxt(folder / f"{name}.pose.txt", full, fmt="%.17g")
    numbers = sorted({int(label.removeprefix("seq-")) for label in recording.sequences})
    lines = [f"sequence{number}\n" for number in numbers]
    (folder / "TrainSplit.txt").write_text("".join(lines[:-1]))
    (folder / "TestSplit.txt").write_text(lines[-1])


LAYOUT = Layout("seven_scenes", lambda folder: (folder / "TrainSplit.txt").is_file(), read, write)
