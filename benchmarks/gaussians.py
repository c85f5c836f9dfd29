"""Cost and quality of the reconstructor `gaussians`.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/gaussians.py speed
    ... python benchmarks/gaussians.py speed --only good --steps 150
    ... python benchmarks/gaussians.py presets [FOLDER...] --only draft good

`speed`: milliseconds of a step by stage, from 128x96 up and for several budgets, or at a preset's
size. `presets`: what each `--quality` takes and brings, on a generated scene, or on captures from
disk. Seconds are the processor's.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from reconstructors import generated, scores

import fsel
from fsel.core.capture import Capture
from fsel.reconstruct import Model
from fsel.reconstruct.gaussians import (
    Gaussians,
    gradients,
    losses,
    optimiser,
    projection,
    rasterize,
    tiles,
)
from fsel.reconstruct.gaussians.settings import QUALITIES

FAMILIES = ("mipnerf360", "tanks_and_temples", "seven_scenes")  # filmed without distortion
FRAMES, FEW = 160, 60  # few of large images, which take long to generate
SIZES = ((128, 5000), (128, 20_000), (128, 50_000), (181, 20_000), (256, 20_000))
STAGES = (
    (projection, "project"),
    (tiles, "by_depth"),
    (tiles, "arrange"),
    (tiles, "assign"),
    (rasterize, "composite"),
    (losses, "_differentiate"),
    (rasterize, "backward"),
    (rasterize, "gather"),
    (gradients, "backward"),
    (optimiser, "penalise"),
    (optimiser, "_update"),
    (optimiser, "shake"),
)


def split(capture: Capture, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`count` evenly spaced frames and every twelfth frame, which is held out."""
    held_out = np.arange(3, len(capture), 12)
    rest = np.setdiff1d(np.arange(len(capture)), held_out)
    return rest[np.linspace(0, len(rest) - 1, count).astype(int)], held_out


@contextmanager
def counted(spent: dict[str, float]) -> Iterator[None]:
    """Add up the seconds of each stage while the context lasts."""
    kept = [(module, name, getattr(module, name)) for module, name in STAGES]

    def timing(key, function):
        def call(*arguments):
            start = time.process_time()
            result = function(*arguments)
            spent[key] = spent.get(key, 0.0) + time.process_time() - start
            return result

        return call

    for module, name, function in kept:
        label = f"{module.__name__.rpartition('.')[2]}.{name}"
        setattr(module, name, timing(label, function))
    try:
        yield
    finally:
        for module, name, function in kept:
            setattr(module, name, function)


def speed(arguments: argparse.Namespace) -> None:
    """Print milliseconds a step, by pixels and Gaussians, and by stage."""
    warm = generated(FAMILIES[0], 0)
    Gaussians(warm, steps=120, gaussians=1000).fit(split(warm, 4)[0])
    chosen = [QUALITIES[name] for name in arguments.only or ()]
    for width, budget in [(one.long_side, one.gaussians) for one in chosen] or SIZES:
        frames = FRAMES if width <= SIZES[-1][0] else FEW
        capture = warm if width == 128 else generated(FAMILIES[0], 0, width, frames)
        spent: dict[str, float] = {}
        with counted(spent):
            start = time.process_time()
            model = Gaussians(capture, steps=arguments.steps, gaussians=budget)
            before, peak = stepped(model, split(capture, 30)[0])
            total = time.process_time() - start - before
        each = 1e3 / arguments.steps
        print(
            f"{width}x{capture.size[1]}, {budget} Gaussians: {total * each:.2f} ms a step, "
            f"start {before:.1f} s, peak {peak / 2**20:.0f} MiB"
        )
        print("   ", ", ".join(f"{key} {value * each:.2f}" for key, value in spent.items()))


def stepped(bound: Gaussians, frames: np.ndarray) -> tuple[float, int]:
    """Seconds until the first step began, and the peak memory of a fit."""
    start, marks = time.process_time(), []

    def mark() -> bool:
        if not marks:
            marks.append(time.process_time() - start)
        return False

    return (*marks, model.peak_bytes) if (model := bound.fit(frames, stop=mark)) else (0.0, 0)


def report(capture: Capture, count: int, name: str, bound: Gaussians) -> None:
    """Fit, and print scores on training and held-out frames."""
    frames, held_out = split(capture, count)
    start = time.process_time()
    model: Model = bound.fit(frames)
    seconds = time.process_time() - start
    within = scores(model, capture, frames[:: max(1, len(frames) // 10)])
    beyond = scores(model, capture, held_out)
    print(
        f"{capture.source}, K = {len(frames)}, {name}: held-out PSNR {beyond[0]:.2f} SSIM "
        f"{beyond[1]:.3f} GMSD {beyond[2]:.3f}, training PSNR {within[0]:.2f}, "
        f"{model.primitives} primitives, {seconds:.0f} s, peak {model.peak_bytes / 2**20:.0f} MiB",
        flush=True,
    )


def presets(arguments: argparse.Namespace) -> None:
    """Print scores of every quality with thirty frames."""
    for name, one in QUALITIES.items():
        if arguments.only and name not in arguments.only:
            continue
        read = [fsel.read_capture(f, long_side=one.long_side) for f in arguments.folders]
        for capture in read or [generated(FAMILIES[1], 2, one.long_side, FEW)]:
            label = f"{name}, {max(capture.size)} pixels"
            report(capture, 30, label, Gaussians(capture, **one.settings))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("what", choices=("speed", "presets"))
    parser.add_argument("folders", nargs="*", help="captures on disk")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--only", nargs="+", help="names of presets")
    arguments = parser.parse_args()
    globals()[arguments.what](arguments)


if __name__ == "__main__":
    main()
