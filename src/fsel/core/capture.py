"""The one in-memory model of a posed sequence, and its canonical form on disk."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.core.files import atomic, mapped_array, read_columns, read_metadata, write_parquet
from fsel.core.geometry import camera_centers, check_poses, merged
from fsel.core.points import SparsePoints, points_from_table, points_table
from fsel.core.wording import counted

POSE = tuple(f"w2c_{row}{column}" for row in range(3) for column in range(4))
INTRINSICS = ("fx", "fy", "cx", "cy")
ATTRIBUTES = "PANDAS_ATTRS"  # of a Parquet file's metadata, what pandas reads as `attrs`


@dataclass(frozen=True)
class Views:
    """Camera poses without images: what a selector may know of its targets.

    Attributes:
        world_to_camera: (T, 3, 4) float64, OpenCV axes (x right, y down, z forward).
        intrinsics: (T, 4) float64, fx, fy, cx, cy in pixels at `size`; the top-left pixel's centre
            is (0.5, 0.5).
        size: (width, height) in pixels.
    """

    world_to_camera: np.ndarray
    intrinsics: np.ndarray
    size: tuple[int, int]

    def __repr__(self) -> str:
        width, height = self.size
        return f"Views({counted(len(self), 'pose')}, {width}x{height})"

    @cached_property
    def centers(self) -> np.ndarray:
        """(T, 3) camera centres, world units."""
        return merged(camera_centers(self.world_to_camera))

    @property
    def axes(self) -> np.ndarray:
        """(T, 3) unit optical axes in the world."""
        return self.world_to_camera[:, 2, :3]

    @property
    def half_fov(self) -> np.ndarray:
        """(T,) half of the larger field of view, radians."""
        return np.arctan(np.max(np.asarray(self.size) / (2 * self.intrinsics[:, :2]), axis=1))

    def __len__(self) -> int:
        return len(self.world_to_camera)

    def subset(self, rows: np.ndarray | slice) -> Views:
        """Return the views at some rows, in that order."""
        return Views(self.world_to_camera[rows], self.intrinsics[rows], self.size)

    def joined(self, others: Views) -> Views:
        """Join these views and others of the same size."""
        poses = np.concatenate([self.world_to_camera, others.world_to_camera])
        return Views(poses, np.concatenate([self.intrinsics, others.intrinsics]), self.size)


@dataclass(frozen=True, eq=False)  # by identity: arrays have no one truth
class Capture:
    """A posed image sequence, validated once on construction.

    Attributes:
        names: N frame names in natural order, distinct.
        world_to_camera: (N, 3, 4) float64, OpenCV axes.
        intrinsics: (N, 4) float64, as in `Views`, at the working size.
        images: (N, h, w, 3) uint8, undistorted, RGB; may be a read-only memory map, or a
            sequence that opens files when indexed (`fsel.captures.canonical.LazyImages`).
        sequences: N labels of the recording pass each frame belongs to.
        masks: (N, h, w) bool, True where a pixel counts, or None.
        source: what was read, in words (layout and folder).
        files: what the files say of these frames, for exports
            (`fsel.captures.layouts.contract.RawCapture`); None where none were read.

    Raises:
        ValueError: for sizes that disagree, values not finite, or a pose that is no rotation.
    """

    names: tuple[str, ...]
    world_to_camera: np.ndarray
    intrinsics: np.ndarray
    images: np.ndarray
    sequences: tuple[str, ...]
    points: SparsePoints | None = None
    masks: np.ndarray | None = None
    source: str = ""
    files: Any = None

    def __repr__(self) -> str:
        width, height = self.size
        passes = counted(len(set(self.sequences)), "sequence")
        points = 0 if self.points is None else len(self.points.xyz)
        where = f"; {self.source}" if self.source else ""
        return (
            f"Capture({counted(len(self), 'frame')} of {width}x{height}, {passes}, "
            f"{counted(points, 'point')}{where})"
        )

    def __post_init__(self) -> None:
        n, k = len(self.names), self.intrinsics
        self._expect(n > 0, "a capture needs at least one frame")
        self._expect(len(set(self.names)) == n, "frame names must be distinct")
        shapes = {"world_to_camera": (n, 3, 4), "intrinsics": (n, 4)}
        shapes |= {} if self.masks is None else {"masks": self.images.shape[:3]}
        for name, wanted in shapes.items():
            shape = getattr(self, name).shape
            self._expect(shape == wanted, f"{name} must be {wanted}, got {shape}")
        self._expect(
            self.images.ndim == 4 and len(self.images) == n and self.images.dtype == np.uint8,
            f"images must be ({n}, h, w, 3) uint8, got {self.images.shape} {self.images.dtype}",
        )
        self._expect(len(self.sequences) == n, f"sequences must name {n} frames")
        check_poses(self.names, self.world_to_camera, self.source)
        sound = np.isfinite(k).all(axis=1) & (k[:, :2] > 0).all(axis=1)
        first = int(np.argmin(sound))  # of those that are not
        said = f"intrinsics must be finite with positive focal lengths, got {k[first].tolist()}"
        self._expect(bool(sound.all()), f"frame {self.names[first]!r}: {said}")

    def _expect(self, holds: bool, message: str) -> None:
        if not holds:
            raise ValueError(f"{self.source}: {message}" if self.source else message)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the working images, pixels."""
        return self.images.shape[2], self.images.shape[1]

    @cached_property
    def views(self) -> Views:
        """Every frame's pose and intrinsics."""
        return Views(self.world_to_camera, self.intrinsics, self.size)

    @property
    def centers(self) -> np.ndarray:
        """(N, 3) camera centres, world units."""
        return self.views.centers

    @property
    def axes(self) -> np.ndarray:
        """(N, 3) unit optical axes."""
        return self.views.axes

    def view(self, frames: np.ndarray) -> Views:
        """Return the poses of the given frames, without their images."""
        return self.views.subset(frames)

    def subset(self, frames: np.ndarray, images: np.ndarray | None = None) -> Capture:
        """Return a capture of (n,) distinct frames, in the given order, and of what they observe.

        `images` are theirs, (n, h, w, 3) uint8, where they are in memory already.

        Example:
            >>> len(fsel.read_capture("captures/garden").subset([0, 8, 16]))
            3
        """
        return replace(
            self,
            names=tuple(self.names[frame] for frame in frames),
            world_to_camera=self.world_to_camera[frames],
            intrinsics=self.intrinsics[frames],
            images=np.asarray(self.images[frames]) if images is None else images,
            sequences=tuple(self.sequences[frame] for frame in frames),
            points=None if self.points is None else self.points.seen_from(frames, len(self)),
            masks=None if self.masks is None else np.asarray(self.masks[frames]),
            files=None if self.files is None else self.files.subset([int(i) for i in frames]),
        )

    def resized(self, long_side: int) -> Capture:
        """Reduce the images to `long_side` pixels, by area means.

        Example:
            >>> fsel.read_capture("captures/garden").resized(32).size
            (32, 24)
        """
        width, height = self.size
        scale = long_side / max(width, height)
        if scale >= 1:
            return self
        new = (max(1, round(width * scale)), max(1, round(height * scale)))
        shrunk = partial(cv2.resize, dsize=new, interpolation=cv2.INTER_AREA)
        factors = np.array([new[0] / width, new[1] / height])
        masks = None
        if self.masks is not None:
            masks = np.stack([shrunk(mask.astype(np.float32)) > 0.5 for mask in self.masks])
        return replace(
            self,
            intrinsics=self.intrinsics * np.tile(factors, 2),
            images=np.stack([shrunk(np.asarray(image)) for image in self.images]),
            masks=masks,
        )

    def save(self, folder: str | Path, **details: Any) -> None:
        """Write frames.parquet, points.parquet, images.npy and masks.npy into `folder`.

        The files are the same for every capture: masks.npy is empty where there are no masks.
        Arrays that already are those files, streamed there while they were made, stay as they are.
        `details` of how the capture was read go into the metadata of frames.parquet.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        frames = {"frame": np.arange(len(self)), "name": self.names, "sequence": self.sequences}
        frames |= zip(POSE, self.world_to_camera.reshape(-1, 12).T, strict=True)
        frames |= zip(INTRINSICS, self.intrinsics.T, strict=True)
        found = {ATTRIBUTES: json.dumps({"source": self.source, **details})}
        write_parquet(frames, folder / "frames.parquet", found)
        write_parquet(points_table(self.points), folder / "points.parquet", {})
        _save_array(self.images, folder / "images.npy")
        none = np.empty((0, *self.images.shape[1:3]), bool)
        _save_array(none if self.masks is None else self.masks, folder / "masks.npy")

    @classmethod
    def load(cls, folder: str | Path) -> Capture:
        """Read what `save` wrote; images stay on disk until touched."""
        folder = Path(folder)
        frames = read_columns(folder / "frames.parquet")
        found = json.loads(read_metadata(folder / "frames.parquet").get(ATTRIBUTES, "{}"))
        stored = folder / "masks.npy"  # none in folders of earlier versions
        masks = mapped_array(stored) if stored.exists() else None
        return cls(
            names=tuple(frames["name"]),
            world_to_camera=np.array([frames[c] for c in POSE]).T.reshape(-1, 3, 4),
            intrinsics=np.array([frames[c] for c in INTRINSICS]).T,
            images=mapped_array(folder / "images.npy"),
            sequences=tuple(frames["sequence"]),
            points=points_from_table(read_columns(folder / "points.parquet")),
            masks=None if masks is None or not len(masks) else masks,
            source=found.get("source", str(folder)),
        )


def _save_array(array: np.ndarray, path: Path) -> None:
    stored = getattr(array, "filename", None)
    if stored is None or Path(stored) != path.resolve():
        with atomic(path) as temporary, temporary.open("wb") as file:
            np.save(file, np.ascontiguousarray(array))
