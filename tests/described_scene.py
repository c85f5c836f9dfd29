"""A small canonical capture with all that selection reads."""

import numpy as np

from fsel.core.capture import Capture
from fsel.stages.describe import describe
from fsel.stages.split import split
from fsel.synthetic import record


def filmed(frames=40, family="dl3dv"):
    """Generated frames of 32x24."""
    made = record(family, 3, frames=frames, width=32, height=24)
    focal = made.camera.params[0]
    camera = np.tile([focal, focal, 16.0, 12.0], (frames, 1))
    return Capture(made.names, made.world_to_camera, camera, made.images, made.sequences)


def save_described(capture, folder):
    """The canonical capture with descriptors, in a folder."""
    capture.save(folder)
    describe(folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    return folder


def write_scene(folder):
    """40 generated frames with descriptors and one draw of four targets."""
    save_described(filmed(), folder)
    split(folder, [folder / "split.parquet"], targets=4, seed=1, config="c")
    return folder
