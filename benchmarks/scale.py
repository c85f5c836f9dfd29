"""Time and memory of the stages on captures of 1,000 to 10,000 frames.

A capture of 250 embedded frames is laid out again and again side by side, with its images and its
sparse points, until it has the frames asked for; the raw one that `ingest` reads is images of
640x480, links to a few files. Every stage, and every method of `select`, runs in a process of its
own. Prints seconds of the processor and peak memory; writes the numbers as JSON. The bounds are
1.5 GB and two minutes.

    OMP_NUM_THREADS=1 python benchmarks/scale.py scale.json --frames 2000 10000
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.read import read_folder
from fsel.core.capture import Capture
from fsel.core.files import write_table
from fsel.core.points import SparsePoints
from fsel.core.problem import Problem
from fsel.evaluation import measuring
from fsel.selectors.baselines import METHODS
from fsel.stages.describe import describe
from fsel.stages.evaluate import evaluate
from fsel.stages.features import features
from fsel.stages.generate import generate
from fsel.stages.ingest import ingest
from fsel.stages.label import label
from fsel.stages.split import split
from fsel.stages.split_labelled import split_labelled

FRAMES = (1000, 2000, 5000, 10_000)
BASE, TARGETS, K = 250, 15, 50
STORED, SIDE = 128, 64  # pixels of the longer side of stored images, and of reconstructions
PASSED, PHOTOS, RAW = 1000, 40, (640, 480)  # raw: frames a pass, files behind the links, pixels
SEARCH = {
    **{"k": K, "population": 8},
    "farthest": 3,
    "uniform": 2,
    "generations": 3,
    "elites": 2,
    "tournament": 4,
    "crossover": 0.8,
    "mutation": 0.3,
    "stored": 4,
    "kept": 2,
}
FITNESS: Mapping[str, Mapping] = {"psnr": {}, "ssim": {}, "gmsd": {}}


def base_capture(folder: Path) -> Capture:
    """The embedded capture that is repeated."""
    raw, size = folder / "raw", {"width": STORED, "height": STORED * 3 // 4}
    generate(raw, layout="dl3dv", family="dl3dv", seed=0, frames=BASE, **size)
    return read_folder(raw, long_side=STORED, layout="dl3dv").capture


def laid_out(base: Capture, count: int) -> Capture:
    """Copies of a capture side by side, `count` frames in all."""
    copies, size = -(-count // len(base)), len(base)
    apart = 3 * np.linalg.norm(base.centers - base.centers.mean(axis=0), axis=1).max()
    rows = np.arange(count) % size
    shift = np.zeros((count, 3))
    shift[:, 0] = apart * (np.arange(count) // size)
    poses = base.world_to_camera[rows].copy()
    poses[:, :, 3] -= np.einsum("nij,nj->ni", poses[:, :, :3], shift)
    return replace(
        base,
        names=tuple(f"{i:06d}" for i in range(count)),
        world_to_camera=poses,
        intrinsics=base.intrinsics[rows],
        images=base.images[rows],
        sequences=("pass",) * count,
        points=_points(base.points, copies, size, count, apart),
        masks=None,
    )


def _points(points: SparsePoints, copies: int, size: int, count: int, apart: float):
    step = np.array([apart, 0, 0])
    frame = np.concatenate([points.track_frame + c * size for c in range(copies)])
    point = np.concatenate([points.track_point + c * len(points.xyz) for c in range(copies)])
    there = frame < count
    return SparsePoints(
        xyz=np.concatenate([points.xyz + c * step for c in range(copies)]),
        rgb=np.tile(points.rgb, (copies, 1)),
        track_point=point[there],
        track_frame=frame[there],
    )


def write_raw(folder: Path, passes: int) -> None:
    """Write passes through a corridor in 7-Scenes' layout; images are links to a few files."""
    rng, store = np.random.default_rng(0), folder / "images"
    store.mkdir(parents=True)
    for i in range(PHOTOS):
        coarse = rng.integers(0, 255, (60, 80, 3), dtype=np.uint8)
        image = cv2.resize(coarse, RAW, interpolation=cv2.INTER_CUBIC)
        cv2.imwrite(str(store / f"{i}.png"), image, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    for p in range(1, passes + 1):
        home = folder / "scene" / f"seq-{p:02d}"
        home.mkdir(parents=True)
        for i in range(PASSED):
            stem = home / f"frame-{i:06d}"
            os.link(store / f"{(i * passes + p) % PHOTOS}.png", f"{stem}.color.png")
            pose = np.eye(4)
            pose[:3, 3] = [0.01 * i, 0.1 * p, 0]
            np.savetxt(f"{stem}.pose.txt", pose)
    names = [f"sequence{p}\n" for p in range(1, passes + 1)]
    (folder / "scene" / "TrainSplit.txt").write_text("".join(names[:-1]))
    (folder / "scene" / "TestSplit.txt").write_text(names[-1])


def stages(folder: Path) -> dict[str, Callable[[], None]]:
    """Name -> a stage on the capture in a folder, in the order in which they need each other."""
    draw = folder / "split.parquet"
    reconstruction = {"name": "splats", "long_side": SIDE, "settings": {}}

    def selected(method: str) -> Path:
        return folder / f"picks_{method}.parquet"

    def picks(method: str) -> Callable[[], None]:
        def work() -> None:
            problem = Problem.load(folder, draw)
            runs = [measuring.Run(METHODS[method], 0)]
            made = measuring.select(problem, runs, [K], measuring.rng_by_name(0))
            write_table(made, selected(method), units=measuring.PICK_UNITS, config="")

        return work

    def judged(method: str) -> Callable[[], None]:
        made = [folder / f"evaluation_{method}.parquet"]
        common = {"reconstruction": reconstruction, "metrics": FITNESS, "config": ""}
        return lambda: evaluate(folder, [draw], [selected(method)], made, **common)

    def labelled() -> None:
        label(
            folder,
            folder / "splits.parquet",
            [folder / "p25.parquet"],
            coverages=[25],
            seed=0,
            search=SEARCH,
            reconstruction=reconstruction,
            fitness=FITNESS,
            inputs=[folder / "images.npy"],
            config="",
        )

    reading = {"layout": "seven_scenes"}
    into = folder.parent / f"{folder.name}-ingested"
    raw = folder.parent / f"{folder.name}-raw" / "scene"
    return {
        "ingest": lambda: ingest(raw, into, long_side=STORED, at_least=K, reading=reading),
        "describe": lambda: describe(
            folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config=""
        ),
        "split": lambda: split(folder, [draw], targets=TARGETS, seed=0, config=""),
        "features": lambda: features(folder, [draw], [folder / "features.parquet"], config=""),
        **{f"select/{name}": picks(name) for name in METHODS},
        "evaluate/uniform": judged("uniform"),
        "evaluate/all": judged("all"),
        "split_labelled": lambda: split_labelled(
            folder, folder / "splits.parquet", coverages=[25], seed=0, config=""
        ),
        "label": labelled,
    }


def alone(folder: Path, name: str) -> dict[str, float]:
    """What one stage takes, imports and compiled code on disk included."""
    command = [sys.executable, __file__, "--stage", name, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
        print(f"  {name}: {last}", file=sys.stderr, flush=True)
        return {}
    return json.loads(done.stdout.splitlines()[-1])


def run(work: Callable[[], None]) -> None:
    """One stage in this process; prints seconds of the processor and peak memory in MB."""
    started = time.process_time()
    work()
    seconds = time.process_time() - started
    status = Path("/proc/self/status").read_text()
    peak = int(re.findall(r"VmHWM:\s+(\d+) kB", status)[0]) / 1024
    print(json.dumps({"seconds": seconds, "peak_mb": peak}))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--frames", type=int, nargs="+", default=list(FRAMES))
    parser.add_argument("--stage", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.stage:
        run(stages(options.out)[options.stage])
        return
    by_stage: dict[str, dict[int, dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        base = base_capture(home)
        for count in options.frames:
            folder = home / str(count)
            laid_out(base, count).save(folder)
            write_raw(home / f"{count}-raw", -(-count // PASSED))
            for stage in stages(folder):
                by_stage.setdefault(stage, {})[count] = alone(folder, stage)
                print(count, stage, by_stage[stage][count], flush=True)
            options.out.write_text(json.dumps({"stages": by_stage}, indent=1))


if __name__ == "__main__":
    main()
