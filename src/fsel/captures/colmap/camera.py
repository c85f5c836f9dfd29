"""A camera: COLMAP's model of it at an image size; and the import of pycolmap.

Everything imports pycolmap from here, without the signal handlers that its log installs: they would
print a C++ stack at the signal TERM. Outside the main thread pycolmap's stay.
"""

from __future__ import annotations

import signal
import threading
from dataclasses import dataclass

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_main = threading.current_thread() is threading.main_thread()
_handlers = {number: signal.getsignal(number) for number in _SIGNALS if _main}
_masked = getattr(signal, "pthread_sigmask", None)  # Windows has none
_mask = _masked and _masked(signal.SIG_BLOCK, _SIGNALS)  # they wait meanwhile
try:
    import pycolmap
finally:
    for _number, _handler in _handlers.items():
        if _handler is not None:  # else it is none of Python's
            signal.signal(_number, _handler)
    if _masked:
        _masked(signal.SIG_SETMASK, _mask)

__all__ = ["Camera", "brown", "pycolmap"]


@dataclass(frozen=True)
class Camera:
    """A COLMAP camera model at a given image size, pixels; top-left pixel centre (0.5, 0.5)."""

    model: str  # COLMAP's name: SIMPLE_PINHOLE, PINHOLE, OPENCV, OPENCV_FISHEYE, ...
    width: int
    height: int
    params: tuple[float, ...]  # in COLMAP's order

    @property
    def colmap(self) -> pycolmap.Camera:
        """Return the same camera for pycolmap, which projects, unprojects and undistorts."""
        return pycolmap.Camera(
            model=self.model, width=self.width, height=self.height, params=list(self.params)
        )


def brown(size: tuple[int, int], pinhole: tuple[float, ...], *terms: float) -> Camera:
    """Return the simplest camera of fx, fy, cx, cy and OpenCV's terms k1, k2, p1, p2 and k3."""
    if terms[4]:
        return Camera("FULL_OPENCV", *size, (*pinhole, *terms, 0.0, 0.0, 0.0))
    extra = terms[:4] if any(terms) else ()
    return Camera("OPENCV" if extra else "PINHOLE", *size, (*pinhole, *extra))
