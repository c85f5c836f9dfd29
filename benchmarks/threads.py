"""Seconds by threads of what a person waits for; writes docs/results/threads.md.

    python benchmarks/threads.py [--repeats 6]
    FSEL_THREADS=2 python benchmarks/threads.py --poses CAPTURE... [--every 2]

One and two threads take turns in one process, of some steps of `gaussians` each; the medians of
seconds and of their ratios count. A further figure leaves out who else uses the machine: the
processor's seconds until the last thread would end, if ranges were run one after the other and each
given to the first thread free; of these the least of the repeats.
`--poses` prints what COLMAP's mappers place of some frames, and how much a second run differs.
"""

import argparse
import heapq
import os
import subprocess
import sys
import time
import timeit
from itertools import islice
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
from fsel.core.threads import side_by_side
from fsel.reconstruct.configured import Peak
from fsel.reconstruct.gaussians import Gaussians, losses, optimiser, render
from fsel.reconstruct.gaussians.training import Training
from fsel.reconstruct.radiance_field import RadianceField, grid
from fsel.reconstruct.radiance_field import training as field
from fsel.reconstruct.splats import Splats, fusion, reconstructor
from fsel.selection.small_fits import small_fits

PAGE = Path(__file__).parents[1] / "docs/results/threads.md"
SIZES = (  # pixels, Gaussians, frames, steps of a turn
    (128, 6000, 30, 128),
    (384, 20_000, 20, 32),
    (640, 60_000, 12, 16),
)
WITHIN = 0.02  # of the extent of the cameras
SHARED, COUNTS = (losses, optimiser, render, reconstructor, fusion, field, grid), (1, 2, 4, 8)
HEAD = """# Seconds by threads

`python benchmarks/threads.py`, on {cores} cores, at a load of {load:.1f} when it began: the second
column says little where others use the cores. Times as fast: the median of the turns. By ranges:
the same by the processor's seconds until the last thread would end, without others and the way to a
thread; the last by Amdahl, on 8 from what is outside of ranges. Moved: what reading and writing
parameters, gradients and moments takes of a step, at the {rate:.1f} GB/s that a thread copies.

| | seconds, 1 and 2 threads | times as fast | by ranges, 2, 4, 8, Amdahl | MB, 1, 2, 8 | \
moved | same bytes |
|---|---|---|---|---|---|---|
"""


def cases():
    """Yield names, a function of no arguments for each number of threads, its steps, and bytes
    of a step."""
    capture, even = generated("mipnerf360", 0, 128, 40), np.arange(0, 40, 2)
    splats = [lambda: Splats(capture).fit(even).splats] * len(COUNTS)
    yield "`splats`, 20 frames, 128 px", splats, 1, 0
    quick = RadianceField(capture, sides=(40, 80), steps=(60, 60))
    yield "`radiance_field`, the same", [lambda: quick.fit(even).grid.color] * len(COUNTS), 1, 0
    score = small_fits(capture, even + 1, [even])
    trials = [lambda: [*side_by_side(lambda seed: score(even, seed), range(4))]]
    yield "4 trials of `fsel select`", trials * len(COUNTS), 1, 0
    for width, budget, frames, steps in SIZES:
        bound = Gaussians(generated("mipnerf360", 0, width, frames), gaussians=budget)
        start, table = bound._start(bound.capture), "step of `gaussians`, {} px, {:,}"
        made = [Training(bound.capture, start, bound.settings) for _ in COUNTS]
        works = [lambda t=t, n=steps: ([t.step(9) for _ in range(n)], t.table)[1] for t in made]
        yield table.format(width, budget), works, steps, 4 * 2 * made[0].table.nbytes


def most_held(case: int, count: int) -> str:
    """Return the MB that a case takes at most on so many threads, in a process of its own."""
    words = [sys.executable, __file__, "--memory", str(case)]
    environment = os.environ | {"FSEL_THREADS": str(count)}
    return subprocess.check_output(words, env=environment, text=True).strip()


def by_ranges(work, count: int) -> np.ndarray:
    """Return the processor's seconds until the last thread would end, and those out of ranges."""
    saved, clock, kept = [], time.thread_time, render.spread

    def spread(part, parts):
        ends, made, began = [0.0] * count, [], clock()
        for one in parts:
            start = clock()
            made.append(part(*one))
            heapq.heapreplace(ends, ends[0] + clock() - start)
        saved.append(np.array([clock() - began - max(ends), clock() - began]))
        return made

    for module in SHARED:
        module.spread = spread
    start = clock()
    work()
    seconds = clock() - start - sum(saved)
    for module in SHARED:
        module.spread = kept
    return seconds


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
    parser.add_argument("--repeats", type=int, default=6, help="of all cases")
    parser.add_argument("--memory", type=int, help="a case, whose MB are printed")
    parser.add_argument("--poses", type=Path, nargs="+", default=[], help="captures on disk")
    parser.add_argument("--every", type=int, default=1, help="frames of them, one in so many")
    arguments = parser.parse_args()
    for folder in arguments.poses:
        poses(folder, arguments.every)
    if arguments.poses:
        return
    if arguments.memory is not None:
        works, peak = next(islice(cases(), arguments.memory, None))[1], Peak()
        works[0]()
        print(peak.bytes >> 20)
        return
    source, target = np.ones((2, 1 << 25))
    copying = min(timeit.repeat(lambda: np.copyto(target, source), number=1, repeat=8))
    rate, load = 2 * source.nbytes / copying, os.getloadavg()[0]
    page = HEAD.format(cores=os.cpu_count(), load=load, rate=rate / 1e9)
    for case, (name, works, steps, moved) in enumerate(cases()):
        wall, alone, same = np.empty((arguments.repeats, 4)), np.full((4, 2), 1e9), True
        for turn in range(arguments.repeats):
            found = []
            for i, (count, work) in enumerate(zip(COUNTS, works, strict=True)):
                fsel.set_threads(count)
                start = time.perf_counter()
                made = work()
                wall[turn, i] = (time.perf_counter() - start) / steps
                found.append(np.asarray(made).tobytes())
                if "trials" not in name:
                    alone[i] = np.minimum(alone[i], by_ranges(work, count))
            same = same and len(set(found)) == 1
        (one, two), (whole, serial) = np.median(wall[:, :2], axis=0), alone[0]
        faster = whole / np.append(alone[1:, 0], serial + (whole - serial) / 8)
        memory = " / ".join(most_held(case, count) for count in (1, 2, 8))
        page += f"| {name} | {one:.4f} / {two:.4f} | {np.median(wall[:, 0] / wall[:, 1]):.2f} | "
        page += " / ".join(f"{times:.2f}" for times in faster if "trials" not in name)
        page += f" | {memory} | {moved / rate / one:.0%} | {'yes' if same else 'no'} |\n"
        print(page.splitlines()[-1], flush=True)
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
