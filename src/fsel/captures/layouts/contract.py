"""Contract of layouts: the capture that a reader returns, the recording that a writer is given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.images import files as image_files
from fsel.captures.images.files import Image
from fsel.core.points import RawPoints

SUBJECT = 1  # number of the object that a capture is about


@dataclass(frozen=True)
class Recording:
    """A capture as its sensor saw it, with the exact values that only a renderer has."""

    names: tuple[str, ...]  # N file stems in capture order, natural order too
    world_to_camera: np.ndarray  # (N, 3, 4) float64, OpenCV axes
    camera: Camera  # one for the whole recording
    images: np.ndarray  # (N, h, w, 3) uint8, RGB, distorted as `camera` says
    depth: np.ndarray  # (N, h, w) float32 along the optical axis in world units; 0 where none
    xyz: np.ndarray  # (M, 3) float64 sparse points
    rgb: np.ndarray  # (M, 3) uint8
    track_point: np.ndarray  # (L,) int64 into `xyz`
    track_frame: np.ndarray  # (L,) int64 into `names`
    track_xy: np.ndarray  # (L, 2) float64 pixels in the distorted image
    sequences: tuple[str, ...]  # N labels of the pass each frame belongs to
    bad: np.ndarray  # (N,) bool, frames that the owner marks as unusable
    lost: np.ndarray  # (N,) bool, frames whose pose the owner's tracker lost
    objects: np.ndarray | None = None  # (N, h, w) uint8 object that a pixel shows, 0 for none

    @property
    def masks(self) -> np.ndarray | None:
        """(N, h, w) bool, where the object is that the capture is about; None without objects."""
        return None if self.objects is None else self.objects == SUBJECT

    def write_images(self, folder: Path, ending: str) -> list[str]:
        """Write the images into a folder, and return their files' names."""
        names = [f"{name}.{ending}" for name in self.names]
        image_files.write(self.images, folder, names)
        return names

    def write_masks(self, folder: Path) -> list[str]:
        """Write the masks, if any, as PNG of 0 and 255, and return their files' names."""
        names = [f"{name}.png" for name in self.names]
        if self.masks is not None:
            image_files.write(self.masks.astype(np.uint8) * 255, folder, names)
        return names if self.masks is not None else []


@dataclass(frozen=True)
class RawCapture:
    """A capture as its files say, before images are opened.

    Attributes:
        names: frame names, any order.
        images: file, or frame of a video, of each frame.
        world_to_camera: (N, 3, 4) float64, OpenCV axes.
        cameras: one a frame, at the size that the files state.
        sequences: pass label of each frame.
        masks: mask of each frame, or None.
        mask_values: least and greatest value of a mask's pixels that count.
        points: reads the sparse points as the frames with the given numbers see them, which are
            renumbered in that order; slow. None where there are none.
        dropped: frames left out, and why.
    """

    names: list[str]
    images: Sequence[Image]
    world_to_camera: np.ndarray
    cameras: list[Camera]
    sequences: list[str]
    masks: Sequence[Image] | None = None
    mask_values: tuple[int, int] = (1, 255)
    points: Callable[[tuple[int, ...]], RawPoints | None] | None = None
    dropped: dict[str, str] = field(default_factory=dict)

    def sparse(self) -> RawPoints | None:
        """Return the sparse points, read now."""
        return self.points(tuple(range(len(self.names)))) if self.points else None

    def projected(self, frame: int, xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(m,) rows of (n, 3) points that lie before a frame's camera, and (m, 2) their pixels."""
        pose = self.world_to_camera[frame]
        local = xyz @ pose[:, :3].T + pose[:, 3]
        ahead = np.flatnonzero(local[:, 2] > 0)
        if not len(ahead):
            return ahead, np.empty((0, 2))
        return ahead, np.asarray(self.cameras[frame].colmap.img_from_cam(local[ahead]))

    def subset(self, rows: list[int], reason: str = "") -> RawCapture:
        """Return the frames at `rows`, in that order; the others are dropped for `reason`."""
        kept, points = set(rows), self.points
        gone = {name: reason for i, name in enumerate(self.names) if i not in kept}
        return replace(
            self,
            names=[self.names[i] for i in rows],
            images=[self.images[i] for i in rows],
            world_to_camera=np.asarray(self.world_to_camera, np.float64)[rows],
            cameras=[self.cameras[i] for i in rows],
            sequences=[self.sequences[i] for i in rows],
            masks=[self.masks[i] for i in rows] if self.masks else None,
            points=points and (lambda frames: points(tuple(rows[i] for i in frames))),
            dropped=self.dropped | gone,
        )


def existing(folder: Path, pairs: Sequence[tuple[str, str]]) -> list[tuple[Path, Path]]:
    """Return the pairs of paths in a folder that are both there."""
    found = [(folder / one, folder / other) for one, other in pairs]
    return [pair for pair in found if all(path.exists() for path in pair)]


def one_pass(
    frames: Sequence[tuple[Path, np.ndarray, Camera]], dropped: dict[str, str]
) -> RawCapture:
    """Return the capture of image files, each with its pose and camera, without points."""
    return RawCapture(
        names=[file.name for file, _, _ in frames],
        images=[file for file, _, _ in frames],
        world_to_camera=np.array([pose for _, pose, _ in frames]).reshape(-1, 3, 4),
        cameras=[camera for _, _, camera in frames],
        sequences=["capture"] * len(frames),
        dropped=dropped,
    )


@dataclass(frozen=True)
class Layout:
    """Layout of a dataset on disk.

    Attributes:
        name: key in the registry and in the config.
        recognises: (folder) -> whether it looks like this layout.
        read: (folder, **options) -> raw capture.
        write: (recording, folder) -> None; none for images alone.
        options: keywords that `read` takes.
    """

    name: str
    recognises: Callable[[Path], bool]
    read: Callable[..., RawCapture]
    write: Callable[[Recording, Path], None] | None = None
    options: tuple[str, ...] = ()


def has_file(path: str) -> Callable[[Path], bool]:
    """Return the check whether a folder has a file."""
    return lambda folder: (folder / path).is_file()
