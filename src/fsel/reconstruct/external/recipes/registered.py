"""Any reconstructor of this project as a worker: in an environment, or on a GPU, of its own.

    python registered.py NAME [SETTING=VALUE ...]

NAME is one of `fsel.reconstruct.RECONSTRUCTORS`; values are JSON, or strings. It is bound to the
whole capture, as in one process, so the numbers are the same to the bit.
"""

import json
import sys
from pathlib import Path

from fsel_worker import serve, settings_of

sys.path.append(str(Path(__file__).resolve().parents[4]))  # where it is not installed

from fsel.core.capture import Capture, Views
from fsel.core.points import SparsePoints
from fsel.reconstruct import RECONSTRUCTORS, check_needs

POINTS = ("xyz", "rgb", "track_point", "track_frame")


def value_of(text):
    """A setting's value."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def main(name, *given):
    """Serve a reconstructor with some settings."""
    settings = settings_of(given, value_of)
    check_needs({"name": name, "settings": settings})
    bound = []

    def bind(frames):
        names = tuple(map(str, range(len(frames.images))))
        own = [getattr(frames, part) for part in POINTS]
        points = None if frames.xyz is None else SparsePoints(*own)
        cameras = frames.world_to_camera, frames.intrinsics, frames.images
        capture = Capture(names, *cameras, names, points, frames.masks, source=name)
        bound[:] = [RECONSTRUCTORS.checked(name)(capture, **settings)]

    def fit(subset):
        return bound[0].fit(subset.frames)

    def render(model, views):
        return model.render(Views(views.world_to_camera, views.intrinsics, views.size))

    serve(fit, render, bind, name=name, needs=["capture"])


if __name__ == "__main__":
    main(*sys.argv[1:])
