"""What the reconstructor `radiance_field` costs, and whether picks made for `splats` lead under it.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/radiance_field.py speed
    ... python benchmarks/radiance_field.py picks --seeds 0 1
    ... python benchmarks/radiance_field.py picks FOLDER... --long-side 96

`speed`: a whole fit of 30 frames at 64x48 and at 128x96, by part, and its memory. `picks`: PSNR on
held-out frames of a region, from 20 frames picked by `fsel`, or equally spaced, beside `splats`; on
generated scenes, or on captures from disk. Seconds are the processor's.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import fsel
from fsel.core.capture import Capture
from fsel.core.points import SparsePoints
from fsel.core.split import coverage_split
from fsel.core.subsets import evenly
from fsel.metrics import score_views
from fsel.reconstruct import Model
from fsel.reconstruct.radiance_field import RadianceField, passes, training
from fsel.reconstruct.splats import Splats
from fsel.synthetic import record

FAMILIES = ("mipnerf360", "tanks_and_temples", "seven_scenes")  # filmed without distortion
FRAMES, PICKS, COVERAGE = 160, 20, 40
PARTS = (
    (passes, "loss_and_gradient"),
    (training, "add_variation"),
    (training, "adam_step"),
    (passes, "largest_weights"),
)


def generated(family: str, seed: int, size: tuple[int, int]) -> Capture:
    """A pinhole recording, as ingestion would hand it on."""
    made = record(family, seed, FRAMES, *size)
    return Capture(
        names=made.names,
        world_to_camera=made.world_to_camera,
        intrinsics=np.tile(made.camera.params, (len(made.names), 1)),
        images=made.images,
        sequences=made.sequences,
        points=SparsePoints(made.xyz, made.rgb, made.track_point, made.track_frame),
        source=f"{family} {seed}",
    )


def psnr(model: Model, capture: Capture, frames: np.ndarray) -> float:
    """Mean over views, dB."""
    images = model.render(capture.view(frames))
    return float(score_views(images, np.asarray(capture.images[frames]))[:, 0].mean())


@contextmanager
def timed() -> Iterator[dict[str, float]]:
    """Processor seconds of each part of a fit."""
    spent = dict.fromkeys((name for _, name in PARTS), 0.0)
    kept = [getattr(module, name) for module, name in PARTS]

    def wrapped(function, name):
        def call(*given):
            started = time.process_time()
            result = function(*given)
            spent[name] += time.process_time() - started
            return result

        return call

    for (module, name), function in zip(PARTS, kept, strict=True):
        setattr(module, name, wrapped(function, name))
    try:
        yield spent
    finally:
        for (module, name), function in zip(PARTS, kept, strict=True):
            setattr(module, name, function)


def speed() -> None:
    """Whole fits, the kernels compiled before."""
    for size in ((64, 48), (128, 96)):
        capture = generated("mipnerf360", 100, size)
        frames = evenly(len(capture), 30)
        RadianceField(capture, sides=(8, 12), steps=(1, 1)).fit(frames)
        with timed() as spent:
            started = time.process_time()
            model = RadianceField(capture).fit(frames)
            total = time.process_time() - started
        started = time.process_time()
        model.render(capture.view(frames))
        view = 1e3 * (time.process_time() - started) / len(frames)
        print(f"{size[0]}x{size[1]}: {total:.1f} s, {model.primitives} cells", flush=True)
        print(
            f"  {model.bytes / 1e6:.0f} MB, at most {model.peak_bytes / 1e6:.0f} MB above the start"
        )
        print(f"  {view:.0f} ms a rendered view; train {psnr(model, capture, frames):.2f} dB")
        for name, seconds in spent.items():
            print(f"  {name:20s}{seconds:6.1f} s", flush=True)


def problem(capture: Capture, draw: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Held-out frames of a region; 20 frames picked for them, and 20 equally spaced ones."""
    held_out = coverage_split(capture, COVERAGE, draw).targets
    pool = np.setdiff1d(np.arange(len(capture)), held_out)
    picked = fsel.select(capture, PICKS, targets=held_out.tolist()).indices
    spaced = pool[evenly(len(pool), PICKS)]
    return held_out, {"fsel": picked, "uniform": spaced}


def picks(captures: Iterator[Capture], draw: int) -> None:
    """PSNR of both reconstructors from both picks, a line a capture, and their means."""
    rows = []
    for capture in captures:
        held_out, chosen = problem(capture, draw)
        row = []
        for frames in chosen.values():
            row.append(psnr(Splats(capture).fit(frames), capture, held_out))
            started = time.process_time()
            model = RadianceField(capture).fit(frames)
            row += [psnr(model, capture, held_out), time.process_time() - started]
        rows.append(row)
        print(_line(capture.source, row), flush=True)
    print(_line("mean", np.mean(rows, axis=0)))


def _line(name: str, row) -> str:
    parts = (
        f"{method}: splats {row[at]:.2f} radiance_field {row[at + 1]:.2f} ({row[at + 2]:.0f} s)"
        for method, at in (("fsel", 0), ("uniform", 3))
    )
    return f"{name[-40:]:40s} " + "   ".join(parts)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("speed", "picks"))
    parser.add_argument("folders", nargs="*", type=Path, help="captures on disk, for `picks`")
    parser.add_argument("--seeds", nargs="+", type=int, default=[100])
    parser.add_argument("--long-side", type=int, default=64)
    parser.add_argument("--draw", type=int, default=0)
    options = parser.parse_args()
    if options.what == "speed":
        speed()
    elif options.folders:
        read = (fsel.read_capture(f, long_side=options.long_side) for f in options.folders)
        picks(read, options.draw)
    else:
        size = (options.long_side, options.long_side * 3 // 4)
        made = (generated(family, seed, size) for family in FAMILIES for seed in options.seeds)
        picks(made, options.draw)


if __name__ == "__main__":
    main()
