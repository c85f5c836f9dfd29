"""Arrays that are handed to another process: mapped files, written again in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.core.capture import Capture, Views

POINTS = ("xyz", "rgb", "track_point", "track_frame")


class Arrays:
    """A folder of `.npy` files that stay mapped: to make and to remove files takes milliseconds.

    Attributes:
        folder: is made.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        self._mapped: dict[str, np.memmap] = {}

    def path(self, name: str) -> Path:
        """The file of an array."""
        return self.folder / f"{name}.npy"

    def room(self, name: str, shape: tuple[int, ...], kind: np.dtype) -> np.memmap:
        """A mapped array, with what it held before."""
        found = self._mapped.get(name)
        if found is None or found.shape != shape or found.dtype != kind:
            path = self.path(name)
            path.unlink(missing_ok=True)
            found = np.lib.format.open_memmap(path, mode="w+", dtype=kind, shape=shape)
            self._mapped[name] = found
        return found

    def put(self, name: str, array: np.ndarray) -> Path:
        """Write an array; returns its file."""
        self.room(name, array.shape, array.dtype)[...] = array
        return self.path(name)

    def put_frames(self, capture: Capture, points: bool) -> None:
        """Write frames as docs/reconstructors.md lists them."""
        for name in ("images", "masks", "world_to_camera", "intrinsics"):
            if (array := getattr(capture, name)) is not None:
                self.put(name, array)
        if points and capture.points is not None:
            for name in POINTS:
                self.put(name, getattr(capture.points, name))

    def put_views(self, views: Views) -> Path:
        """Write a row a view: its pose, then its intrinsics."""
        poses = views.world_to_camera.reshape(-1, 12)
        return self.put("views", np.concatenate([poses, views.intrinsics], axis=1))
