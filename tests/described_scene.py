"""A small canonical capture with all that selection reads."""

import numpy as np

from fsel.data.capture import Capture
from fsel.stages.describe import describe
from fsel.stages.split import split
from fsel.synthesis import record


def write_scene(folder):
    """40 generated frames of 32x24 with descriptors and one draw of four targets."""
    made = record("dl3dv", 3, frames=40, width=32, height=24)
    focal = made.camera.params[0]
    camera = np.tile([focal, focal, 16.0, 12.0], (40, 1))
    Capture(made.names, made.world_to_camera, camera, made.images, made.sequences).save(folder)
    describe(folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    split(folder, [folder / "split.parquet"], targets=4, seed=1, config="c")
    return folder
