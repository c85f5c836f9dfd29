"""Milliseconds of a step of `gaussians` by threads, and whether the models are the same.

    python benchmarks/threads.py [--threads 1 2] [--repeats 8] [--steps 8]
    FSEL_THREADS=2 python benchmarks/threads.py --poses CAPTURE... [--every 2]

In one process, the numbers of threads in turn: each goes through the same training, and the best of
its medians counts, since others may use the machine. `--poses` prints what COLMAP's mappers place
of some frames, in order, and how much a second run differs.
"""

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pycolmap
from reconstructors import generated, processor_seconds

import fsel
from fsel.captures.colmap.runs import Part, Work
from fsel.captures.poses import sfm
from fsel.captures.poses.placement import apart
from fsel.captures.read import read_raw
from fsel.core.geometry import camera_centers
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.gaussians.training import Training

SIZES = ((128, 6000, 30), (640, 60_000, 12))  # pixels, Gaussians, frames
WITHIN = 0.02  # of the extent of the cameras


def poses(folder: Path, every: int) -> None:
    """Print what each mapper places, as far as it differs from the capture's own poses, the seconds
    of the processor, and how the model that was kept differs from that of a second run."""
    raw = read_raw(folder)[1]
    raw = raw.subset(range(0, len(raw.names), every), "thinned")
    truth, start = dict(zip(raw.names, raw.world_to_camera, strict=True)), processor_seconds()
    with TemporaryDirectory() as place:
        work = Work(Path(place), [Part(range(len(truth)), ordered=True)])
        first = sfm.place(raw, work)
        spent = processor_seconds() - start
        models = [first.model, first.other or first.model, sfm.place(raw, work).model]
    kept, other, again = (
        {image.name: image.cam_from_world().matrix() for image in model.images.values()}
        for model in models
    )
    print(f"{folder.name}: {len(truth)} frames, {spent:.0f} s; {first.by} {apart_by(kept, truth)}")
    print(f"  the other mapper {apart_by(other, truth)}; again {apart_by(again, kept)}", flush=True)


def apart_by(found: dict[str, np.ndarray], truth: dict[str, np.ndarray]) -> str:
    """Frames placed, those within 2 % of the extent, and medians of degrees and of the extent."""
    names = sorted(set(found) & set(truth))
    one, other = (np.array([poses[name] for name in names]) for poses in (found, truth))
    wanted = camera_centers(other)
    extent = np.linalg.norm(np.ptp(camera_centers(np.array(list(truth.values()))), axis=0))
    options = pycolmap.RANSACOptions(max_error=WITHIN * extent, random_seed=0)
    fit = pycolmap.estimate_sim3d_robust(camera_centers(one), wanted, options)["tgt_from_src"]
    off = np.linalg.norm([fit * at for at in camera_centers(one)] - wanted, axis=1) / extent
    turned, near = apart(one[:, :, :3], other[:, :, :3]), int((off < WITHIN).sum())
    return f"{len(names)} / {near}, {turned:.2f} degrees, {100 * np.median(off):.2f} %"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=8)
    parser.add_argument("--steps", type=int, default=8)
    parser.add_argument("--poses", type=Path, nargs="+", default=[], help="captures on disk")
    parser.add_argument("--every", type=int, default=1, help="frames of them, one in so many")
    arguments = parser.parse_args()
    for folder in arguments.poses:
        poses(folder, arguments.every)
    if arguments.poses:
        return
    for width, budget, frames in SIZES:
        bound = Gaussians(generated("mipnerf360", 0, width, frames), gaussians=budget)
        start = bound._start(bound.capture)
        trained = {n: Training(bound.capture, start, bound.settings) for n in arguments.threads}
        best = dict.fromkeys(trained, np.inf)
        for repeat in range(arguments.repeats):
            for count, training in trained.items():
                fsel.set_threads(count)
                times = [time.perf_counter()]
                for step in range(arguments.steps):
                    training.step(repeat * arguments.steps + step)
                    times.append(time.perf_counter())
                best[count] = min(best[count], float(np.median(np.diff(times))))
        same = len({training.table.tobytes() for training in trained.values()}) == 1
        cells = [f"{n} threads {1e3 * seconds:.2f} ms" for n, seconds in best.items()]
        print(f"{width} px, {budget} Gaussians, same bytes {same}: {', '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
