"""A camera: COLMAP's model of it at an image size."""

from __future__ import annotations

from dataclasses import dataclass

from fsel.captures.colmap.bindings import pycolmap


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
