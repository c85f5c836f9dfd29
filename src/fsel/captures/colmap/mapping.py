"""COLMAP's two mappers: `python -m` of this module maps globally (Pan et al. 2024)."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fsel.captures.colmap import features
from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.failures import VerifiedPair, verified_pairs
from fsel.captures.colmap.pairs import OVERLAP
from fsel.captures.colmap.runs import MIN_PLACED, SEED, Work
from fsel.captures.images.matching import epipolar_distances
from fsel.core.files import emptied
from fsel.core.limits import threads
from fsel.core.programs import LOG, running

GLOBAL, INCREMENTAL = "global", "incremental"
AGREES = 0.004  # of the longer side that a match lies off the epipolar lines: 2 pixels at 480
UNIT = np.array([1.0, 1, 0, 0])  # intrinsics of rays
EXPLAINED, PLACED = 0.85, 0.95  # of the matches and frames, by a model that needs no other
TRACKS = 100  # of an image, that the global mapper places cameras by: it finds the others again
GROWN = 1.4  # a model by so much, all of which is adjusted again: COLMAP's own for videos
PAIRS_TRIED = 30  # to begin with: COLMAP's 200 take minutes where a scene is far away
LEAST_SECONDS = 30  # of the incremental mapper where the global one placed nothing
STEPS, WAIT = 6, 0.1  # of the global mapper, and seconds between looks at its log


class Mapped(NamedTuple):
    """A model, the mapper that made it, and the model of COLMAP's other mapper: empty where it
    placed nothing, None where it was not asked."""

    model: pycolmap.Reconstruction
    by: str = ""
    other: pycolmap.Reconstruction | None = None


def build(
    database: Path, folder: Path, count: int, work: Work, start: Path | None = None
) -> Mapped | None:
    """Map a database of `count` images globally. Where that leaves many matches unexplained, or
    images unplaced, map them incrementally, too, from the model in `start`, while there is time;
    keep the model that explains more."""
    folder = folder.absolute()  # the process works there
    pairs = verified_pairs(database)
    matches = sum(len(pair.places[0]) for pair in pairs)
    rated = [(agreeing(m, pairs), GLOBAL, m) for m in _globally(database, folder, work)]
    most, placed = max(((agree, m.num_reg_images()) for agree, _, m in rated), default=(0, 0))
    clear = most >= EXPLAINED * matches and placed >= PLACED * count
    sure = clear and not any(part.panoramic for part in work.parts)
    work.time.tried()
    asked = not sure and (work.time.left > 0 or not rated)
    if asked:
        made = _incrementally(database, folder, count, work, start)
        rated += [(agreeing(model, pairs), INCREMENTAL, model) for model in made]
    rated.sort(key=lambda one: -one[0])
    if not rated:
        return None
    _, kept, model = rated[0]
    none = pycolmap.Reconstruction() if asked else None
    return Mapped(model, kept, next((other for _, by, other in rated if by != kept), none))


def _globally(database: Path, folder: Path, work: Work) -> list[pycolmap.Reconstruction]:
    """Map in a process of its own, which can be stopped."""
    output = emptied(folder / GLOBAL)
    copy = shutil.copy(database, folder / f"{GLOBAL}.db")  # focal lengths are estimated there
    options = _common(work) | {"mapper": {"track_required_tracks_per_view": TRACKS}}
    words = map(str, (copy, folder / "images", output, json.dumps(options)))
    (folder / LOG).unlink(missing_ok=True)  # of an earlier run
    with running([sys.executable, "-m", __name__, *words], folder, os.environ) as process:
        for _ in work.watch("poses")(_steps(process, folder / LOG, work.time.stop), STEPS):
            pass
        if process.poll() is None:  # time ran out
            return []
    return [pycolmap.Reconstruction(str(path)) for path in sorted(output.iterdir())]


def _steps(process: subprocess.Popen[bytes], log: Path, stop: float) -> Iterator[int]:
    """Yield the number of each step that a process says in its log to have done, in time."""
    done = 0
    while process.poll() is None and time.monotonic() < stop:
        time.sleep(WAIT)
        said = log.read_bytes().count(b" done in ")
        yield from range(done, said)
        done = said


def _incrementally(
    database: Path, folder: Path, count: int, work: Work, start: Path | None
) -> Iterable[pycolmap.Reconstruction]:
    rarely: dict = {"ba_global_frames_ratio": GROWN, "ba_global_points_ratio": GROWN}
    rarely["init_num_trials"] = PAIRS_TRIED
    if work.time.left < math.inf:
        rarely |= {"max_runtime_seconds": max(LEAST_SECONDS, round(work.time.left))}
    placed = iter(work.watch("poses")(range(count), count))  # frames of a model given up come again
    return pycolmap.incremental_mapping(
        database,
        folder / "images",
        emptied(folder / INCREMENTAL),
        pycolmap.IncrementalPipelineOptions(_common(work) | rarely),
        input_path=start or "",
        next_image_callback=lambda: next(placed, None),
    ).values()


def _common(work: Work) -> dict:
    """Options of both mappers."""
    least = features.INLIERS[work.features]
    found = {"random_seed": SEED, "min_num_matches": least, "min_model_size": MIN_PLACED}
    return found | {"num_threads": threads()}


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
