"""What a sensor recorded, before a layout writes it and ingestion undistorts it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.held import pycolmap

SUBJECT = 1  # number of the object that a capture is about


@dataclass(frozen=True)
class Camera:
    """A COLMAP camera model at a given image size.

    Attributes:
        model: COLMAP's name: SIMPLE_PINHOLE, PINHOLE, OPENCV, OPENCV_FISHEYE, ...
        width: pixels.
        height: pixels.
        params: the model's parameters in COLMAP's order, pixels; top-left pixel centre (0.5, 0.5).
    """

    model: str
    width: int
    height: int
    params: tuple[float, ...]

    @property
    def colmap(self) -> pycolmap.Camera:
        """The same camera for pycolmap, which projects, unprojects and undistorts.

        Raises:
            ValueError: for a model that COLMAP does not have, or a wrong number of parameters.
        """
        return pycolmap.Camera(
            model=self.model, width=self.width, height=self.height, params=list(self.params)
        )


@dataclass(frozen=True)
class Recording:
    """A capture as its sensor saw it, with the exact values that only a renderer has.

    Attributes:
        names: N file stems in capture order, natural order too.
        world_to_camera: (N, 3, 4) float64, OpenCV axes.
        camera: one camera for the whole recording.
        images: (N, h, w, 3) uint8, RGB, distorted as `camera` says.
        depth: (N, h, w) float32, distance along the optical axis in world units; 0 where none.
        xyz: (M, 3) float64 sparse points.
        rgb: (M, 3) uint8.
        track_point: (L,) int64 into `xyz`.
        track_frame: (L,) int64 into `names`.
        track_xy: (L, 2) float64 pixels in the distorted image.
        sequences: N labels of the pass each frame belongs to.
        bad: (N,) bool, frames that the owner marks as unusable.
        lost: (N,) bool, frames whose pose the owner's tracker lost.
        objects: (N, h, w) uint8 number of the object that a pixel shows, 0 for none; or None.
    """

    names: tuple[str, ...]
    world_to_camera: np.ndarray
    camera: Camera
    images: np.ndarray
    depth: np.ndarray
    xyz: np.ndarray
    rgb: np.ndarray
    track_point: np.ndarray
    track_frame: np.ndarray
    track_xy: np.ndarray
    sequences: tuple[str, ...]
    bad: np.ndarray
    lost: np.ndarray
    objects: np.ndarray | None = None

    @property
    def masks(self) -> np.ndarray | None:
        """(N, h, w) bool, where the object is that the capture is about; None without objects."""
        return None if self.objects is None else self.objects == SUBJECT
