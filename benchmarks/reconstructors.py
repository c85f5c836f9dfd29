"""Seconds, memory and PSNR of reconstructors on one scene, and the overhead of a worker.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/reconstructors.py splats gaussians ...
    ... python benchmarks/reconstructors.py recipe.yaml...
    ... python benchmarks/reconstructors.py worker

An argument is a name of `fsel.reconstruct.RECONSTRUCTORS`, with its default settings, or a file
with a `reconstruction`, such as those of config/reconstructors. A generated scene of the family
Mip-NeRF 360 at 64x48: 20 frames to reconstruct from, 4 held out. Each has a process of its own.
Seconds are the processor's, with those of the programs that were started; memory is what the model
states. `worker` measures milliseconds a subset beyond the worker's own: one that returns noise, 20
frames out and 15 views back, at 64x48 and 960x540 pixels.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from fsel.core.capture import Capture, SparsePoints
from fsel.metrics import score_views
from fsel.reconstruct import check_needs, reconstructor_of
from fsel.synthetic import record

SIZE = (64, 48)
K, VIEWS, TIMES = 20, 15, 200
NOISE = """
import numpy as np
from fsel_worker import serve

noise = {}

def render(model, views):
    if views.size not in noise:
        shape = (len(views), views.size[1], views.size[0], 3)
        noise[views.size] = np.random.default_rng(0).random(shape, dtype=np.float32)
    return noise[views.size]

serve(lambda subset: None, render, name="noise")
"""


def generated(family: str, seed: int, width: int = 128, frames: int = 160) -> Capture:
    """A pinhole recording, four by three, as ingestion would hand it on."""
    made = record(family, seed, frames=frames, width=width, height=width * 3 // 4)
    return Capture(
        made.names,
        made.world_to_camera,
        np.tile(made.camera.params, (frames, 1)),
        made.images,
        made.sequences,
        SparsePoints(made.xyz, made.rgb, made.track_point, made.track_frame),
        source=f"{family} {seed}",
    )


def processor_seconds() -> float:
    """Seconds of this process and of all that it started and that ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def section_of(name: str) -> dict:
    """A reconstructor as a config names it."""
    if not name.endswith(".yaml"):
        return {"name": name, "settings": {}, "long_side": SIZE[0]}
    section = yaml.safe_load(Path(name).read_text())["reconstruction"]
    return {"settings": {}, **section, "long_side": SIZE[0]}


def measure(section: dict) -> dict[str, float | str]:
    """Measure a fit after one that is not counted, which compiles; a program is started once."""
    check_needs(section)
    capture = generated("mipnerf360", 0, SIZE[0])
    held, frames = np.arange(4, 160, 40), np.arange(0, 160, 8)
    reconstructor = reconstructor_of(capture, section)
    first = 0  # memory is new in the first fit alone
    if section["name"] != "external":
        model = reconstructor.fit(frames)
        model.render(capture.view(held))
        first = model.peak_bytes
    started = processor_seconds()
    model = reconstructor_of(capture, section).fit(frames)
    fitted = processor_seconds()
    scores = score_views(model.render(capture.view(held)), np.asarray(capture.images[held]))
    return {
        "fit": fitted - started,
        "view": (processor_seconds() - fitted) / len(held),
        "memory": max(first, model.peak_bytes) / 1e6,
        "psnr": float(scores[:, 0].mean()),
        "device": model.device,
    }


def worker() -> None:
    """Print the overhead of the protocol, a line a size."""
    from fsel.reconstruct.external import External

    small = generated("mipnerf360", 0, SIZE[0], frames=K + VIEWS)
    for width, height in (SIZE, (960, 540)):
        blank = np.zeros((K + VIEWS, height, width, 3), np.uint8)
        capture = replace(small, images=blank, points=None)
        served, taken = External(capture, serve=[sys.executable, "-c", NOISE]), []
        views = capture.view(np.arange(VIEWS))
        for at in range(TIMES):
            started = time.perf_counter()
            served.fit(VIEWS + (np.arange(K) + at) % K).render(views)
            taken.append((time.perf_counter() - started) * 1e3)
        median, late = np.percentile(taken[10:], [50, 95])
        print(f"{width}x{height}: {median:.1f} ms a subset, 95 % below {late:.1f} ms", flush=True)


def main() -> None:
    """Print a row a reconstructor."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="+")
    parser.add_argument("--one", action="store_true", help="measure here, and print JSON")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(section_of(options.names[0]))))
        return
    if options.names == ["worker"]:
        worker()
        return
    print("| reconstructor | fit, s | a view, s | peak memory, MB | PSNR, dB | device |")
    print("|---|---|---|---|---|---|")
    for name in options.names:
        done = subprocess.run(
            [sys.executable, __file__, "--one", name], stdout=subprocess.PIPE, check=True, text=True
        )
        row = json.loads(done.stdout.splitlines()[-1])
        cells = [f"{row['fit']:.1f}", f"{row['view']:.2f}", f"{row['memory']:.0f}"]
        print(f"| {name} | {' | '.join(cells)} | {row['psnr']:.2f} | {row['device']} |", flush=True)


if __name__ == "__main__":
    main()
