"""COLMAP's two mappers side by side: `python -m` of this module maps globally (Pan et al. 2024)."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fsel.captures.colmap import features
from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.failures import VerifiedPair, verified_pairs
from fsel.captures.colmap.pairs import OVERLAP
from fsel.captures.colmap.runs import MIN_PLACED, SEED, Work
from fsel.captures.images.matching import epipolar_distances
from fsel.core.limits import threads
from fsel.core.programs import running

GLOBAL, INCREMENTAL = "global", "incremental"
AGREES = 0.004  # of the longer side that a match lies off the epipolar lines: 2 pixels at 480
UNIT = np.array([1.0, 1, 0, 0])  # intrinsics of rays


class Mapped(NamedTuple):
    """A model, the mapper that made it, and the model that COLMAP's other mapper made, if any."""

    model: pycolmap.Reconstruction
    by: str = ""
    other: pycolmap.Reconstruction | None = None


def build(
    database: Path, folder: Path, count: int, work: Work, start: Path | None = None
) -> Mapped | None:
    """Map a database of `count` images globally and, going on with the model in `start`,
    incrementally, on half of the threads each; keep what agrees with more of the matches."""
    folder = folder.absolute()  # the process works there
    for by in (GLOBAL, INCREMENTAL):
        shutil.rmtree(folder / by, ignore_errors=True)
        (folder / by).mkdir()
    copy = shutil.copy(database, folder / f"{GLOBAL}.db")  # focal lengths are estimated there
    least = features.INLIERS[work.features]
    common = {"random_seed": SEED, "min_num_matches": least, "min_model_size": MIN_PLACED}
    options = pycolmap.IncrementalPipelineOptions(common | {"num_threads": -(-threads() // 2)})
    share = json.dumps(common | {"num_threads": threads() // 2 or 1})
    words = map(str, (copy, folder / "images", folder / GLOBAL, share))
    placed = iter(work.watch("poses")(itertools.count(), count))
    with running([sys.executable, "-m", __name__, *words], folder, os.environ) as process:
        if threads() == 1:
            process.wait()
        models = pycolmap.incremental_mapping(
            database,
            folder / "images",
            folder / INCREMENTAL,
            options,
            input_path=start or "",
            next_image_callback=lambda: next(placed),
        )
        process.wait()
    wide = [pycolmap.Reconstruction(str(path)) for path in sorted((folder / GLOBAL).iterdir())]
    pairs, built = verified_pairs(database), {GLOBAL: wide, INCREMENTAL: models.values()}
    rated = [(agreeing(model, pairs), by, model) for by, made in built.items() for model in made]
    rated.sort(key=lambda one: -one[0])
    if not rated:
        return None
    _, kept, best = rated[0]
    return Mapped(best, kept, next((model for _, by, model in rated if by != kept), None))


def agreeing(model: pycolmap.Reconstruction, pairs: Iterable[VerifiedPair]) -> int:
    """Return how many verified matches lie on the epipolar lines of a model's poses; of panoramas,
    how many its points were made from."""
    if any(camera.is_spherical() for camera in model.cameras.values()):  # has no focal length
        return model.compute_num_observations()
    count, placed = 0, set(model.reg_image_ids())
    for pair in pairs:
        if placed.issuperset(pair.images):
            images = [model.images[key] for key in pair.images]
            cameras = [model.cameras[image.camera_id] for image in images]
            sides = [max(camera.width, camera.height) for camera in cameras]
            seen = zip(cameras, sides, pair.places, strict=True)
            one, other = (camera.cam_from_img(side * places) for camera, side, places in seen)
            first, second = (image.cam_from_world().matrix() for image in images)
            focal = cameras[0].mean_focal_length() / sides[0]
            distances = epipolar_distances(one, other, first, second, UNIT, UNIT)
            count += int((distances * focal < AGREES).sum())
    return count


def separate(database: Path, names: Sequence[str], breaks: Sequence[int]) -> None:
    """Remove the matches of images, named in order, on both sides of a row before which the path
    breaks, but those of neighbours."""
    stretch = np.searchsorted(breaks, np.arange(len(names)), side="right")
    verified = verified_pairs(database)
    with pycolmap.Database.open(str(database)) as stored:
        keys = {image.name: image.image_id for image in stored.read_all_images()}
        rows = {keys[name]: row for row, name in enumerate(names)}
        for pair in verified:
            i, j = (rows[key] for key in pair.images)
            if stretch[i] != stretch[j] and abs(i - j) > OVERLAP:
                stored.delete_two_view_geometry(*pair.images)


def main(database: str, images: str, output: str, options: str) -> None:
    """Write the global mapper's models, with focal lengths estimated from pairs first."""
    pycolmap.calibrate_view_graph(database, pycolmap.ViewGraphCalibrationOptions(random_seed=SEED))
    settings = pycolmap.GlobalPipelineOptions(json.loads(options))
    pycolmap.global_mapping(database, images, output, settings)


if __name__ == "__main__":
    main(*sys.argv[1:])
