"""What the reconstructor `gaussians` costs, and what its settings are worth.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/gaussians.py speed
    ... python benchmarks/gaussians.py twin
    ... python benchmarks/gaussians.py quality --frames 10 30 all
    ... python benchmarks/gaussians.py settings --frames 10 --seeds 0 1
    ... python benchmarks/gaussians.py captures FOLDER... --long-side 256
    ... python benchmarks/gaussians.py speed --only good --steps 150
    ... python benchmarks/gaussians.py presets [FOLDER...] --only draft good

`speed`: milliseconds of a step by stage, from 128x96 up and for several budgets, or at a preset's
size, and what share of it the memory takes. `twin`: a step of
the float64 torch twin of the tests beside one of the kernels, on a small scene. `quality`: PSNR on
training and held-out frames of generated scenes, beside `splats`. `settings`: the same, one setting
changed at a time, on captures from disk where folders are given. `captures`: the same as `quality`
on captures from disk. `presets`: what each `--quality` takes and brings, on a generated scene or on
captures from disk.
Seconds are the processor's.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import fsel
from fsel.core.capture import Capture, SparsePoints
from fsel.metrics import score_views
from fsel.reconstruct.gaussians import (
    GaussianModel,
    Gaussians,
    gradients,
    losses,
    optimiser,
    projection,
    rasterize,
    tiles,
)
from fsel.reconstruct.gaussians.parameters import width_of
from fsel.reconstruct.gaussians.settings import QUALITIES
from fsel.reconstruct.splats import Splats
from fsel.synthetic import record

FAMILIES = ("mipnerf360", "tanks_and_temples", "seven_scenes")  # filmed without distortion
FRAMES = 160
FEW = 60  # of large images, which take long to generate
SIZES = ((128, 5000), (128, 20_000), (128, 50_000), (181, 20_000), (256, 20_000))
PASSES = 12  # over a visible Gaussian's row: three read it, its gradient is written, read and
# cleared, and Adam reads and writes the row and two moments
STAGES = (
    (projection, "project"),
    (tiles, "sort_rows"),
    (tiles, "assign"),
    (rasterize, "composite"),
    (losses, "loss_gradient"),
    (rasterize, "backward"),
    (gradients, "backward"),
    (optimiser, "penalise"),
    (optimiser, "_update"),
    (optimiser, "shake"),
)
VARIANTS: dict[str, dict] = {
    "defaults": {},
    "no scale penalty": {"scale_penalty": 0.0},
    "scale penalty x 10": {"scale_penalty": 0.1},
    "no opacity penalty": {"opacity_penalty": 0.0},
    "opacity penalty x 10": {"opacity_penalty": 0.1},
    "no penalty, no noise": {"scale_penalty": 0.0, "opacity_penalty": 0.0, "noise": False},
    "no noise": {"noise": False},
    "dropout 0": {"dropout": 0.0},
    "dropout 0.1": {"dropout": 0.1},
    "dropout 0.3": {"dropout": 0.3},
    "degree 0": {"degree": 0},
    "degree 1": {"degree": 1},
    "mean background": {"background": "mean"},
    "from points": {"initial": "points"},
}


def generated(family: str, seed: int, width: int = 128, frames: int = FRAMES) -> Capture:
    """A pinhole recording, as ingestion would hand it on."""
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


def split(capture: Capture, count: int | None) -> tuple[np.ndarray, np.ndarray]:
    """`count` evenly spaced frames (None: all) and every twelfth frame, which is held out."""
    held_out = np.arange(3, len(capture), 12)
    rest = np.setdiff1d(np.arange(len(capture)), held_out)
    if count is None:
        return rest, held_out
    return rest[np.linspace(0, len(rest) - 1, count).astype(int)], held_out


def scores(model, capture: Capture, frames: np.ndarray) -> np.ndarray:
    """Mean PSNR, SSIM and GMSD on some frames."""
    truth = np.asarray(capture.images[frames])
    return score_views(model.render(capture.view(frames)), truth).mean(axis=0)


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


def fitted(capture: Capture, frames: np.ndarray, **settings) -> tuple[GaussianModel, float]:
    """A model and the processor's seconds."""
    start = time.process_time()
    model = Gaussians(capture, **settings).fit(frames)
    return model, time.process_time() - start


def speed(arguments: argparse.Namespace) -> None:
    """Milliseconds a step, by pixels and Gaussians, and by stage."""
    warm = generated(FAMILIES[0], 0)
    fitted(warm, split(warm, 4)[0], steps=120, gaussians=1000)
    chosen = [QUALITIES[name] for name in arguments.only or ()]
    for width, budget in [(one.long_side, one.gaussians) for one in chosen] or SIZES:
        frames = FRAMES if width <= SIZES[-1][0] else FEW
        capture = warm if width == 128 else generated(FAMILIES[0], 0, width, frames)
        spent: dict[str, float] = {}
        with counted(spent):
            start = time.process_time()
            model = Gaussians(capture, steps=arguments.steps, gaussians=budget)
            seen = stepped(model, split(capture, 30)[0])
            total = time.process_time() - start - seen[0]
        each = 1e3 / arguments.steps
        print(
            f"{width}x{capture.size[1]}, {budget} Gaussians: {total * each:.2f} ms a step, "
            f"{arguments.steps / total:.0f} steps a second, start {seen[0]:.1f} s, peak "
            f"{seen[1] / 2**20:.0f} MiB"
        )
        print("   ", ", ".join(f"{key} {value * each:.2f}" for key, value in spent.items()))
        moved, rate = budget * PASSES * width_of(model.settings.degree) * 4, copied()
        print(
            f"    parameters: at most {moved / 1e6:.0f} MB moved a step, {1e3 * moved / rate:.1f} "
            f"ms at the {rate / 1e9:.1f} GB/s of a copy"
        )


def copied() -> float:
    """Bytes a second that one core reads and writes in copying more than its caches hold."""
    source = np.ones(1 << 26, np.float32)
    target, times = np.empty_like(source), []
    for _ in range(5):
        start = time.perf_counter()
        np.copyto(target, source)
        times.append(time.perf_counter() - start)
    return 2 * source.nbytes / min(times)


def stepped(bound: Gaussians, frames: np.ndarray) -> tuple[float, int]:
    """Seconds until the first step began, and the peak memory of a fit."""
    start, marks = time.process_time(), []

    def mark() -> bool:
        if not marks:
            marks.append(time.process_time() - start)
        return False

    return (*marks, model.peak_bytes) if (model := bound.fit(frames, stop=mark)) else (0.0, 0)


def twin(_: argparse.Namespace) -> None:
    """One step of the torch twin and of the kernels: 48x36 pixels, 2,000 Gaussians."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    import gaussian_twin
    import torch

    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    capture = generated(FAMILIES[0], 0, 48)
    frames = split(capture, 8)[0]
    fitted(capture, frames, steps=120, gaussians=2000)
    spent = fitted(capture, frames, steps=520, gaussians=2000)[1]
    spent -= fitted(capture, frames, steps=20, gaussians=2000)[1]
    model = fitted(capture, frames, steps=100, gaussians=2000)[0]
    table = torch.tensor(model.table.astype(np.float64), requires_grad=True)
    pose = torch.tensor(model.frame.local_poses(capture.world_to_camera[frames[:1]])[0])
    truth = torch.tensor(capture.images[frames[0]].transpose(2, 0, 1) / 255)
    start = time.process_time()
    image = gaussian_twin.render(
        table,
        2,
        torch.ones(len(table)),
        pose,
        torch.tensor(capture.intrinsics[frames[0]]),
        capture.size,
        model.near,
        torch.tensor(model.background.astype(np.float64)),
    )
    gaussian_twin.loss(image, truth).backward()
    slow = time.process_time() - start
    print(f"48x36, 2000 Gaussians: kernels {2 * spent:.2f} ms a step, twin {1e3 * slow:.0f} ms")


def report(capture: Capture, count: int | None, name: str, **settings) -> None:
    """Fit, and print scores on training and held-out frames."""
    frames, held_out = split(capture, count)
    model, seconds = fitted(capture, frames, **settings)
    shown = frames[:: max(1, len(frames) // 10)]
    within, beyond = scores(model, capture, shown), scores(model, capture, held_out)
    print(
        f"{capture.source}, K = {len(frames)}, {name}: held-out PSNR {beyond[0]:.2f} SSIM "
        f"{beyond[1]:.3f} GMSD {beyond[2]:.3f}, training PSNR {within[0]:.2f}, "
        f"{model.primitives} Gaussians, {seconds:.0f} s, peak {model.peak_bytes / 2**20:.0f} MiB",
        flush=True,
    )


def beside(capture: Capture, count: int | None) -> None:
    """The scores of `splats`."""
    frames, held_out = split(capture, count)
    model = Splats(capture).fit(frames)
    shown = frames[:: max(1, len(frames) // 10)]
    within, beyond = scores(model, capture, shown), scores(model, capture, held_out)
    print(
        f"{capture.source}, K = {len(frames)}, splats: held-out PSNR {beyond[0]:.2f} SSIM "
        f"{beyond[1]:.3f} GMSD {beyond[2]:.3f}, training PSNR {within[0]:.2f}, "
        f"{model.primitives} splats",
        flush=True,
    )


def quality(arguments: argparse.Namespace) -> None:
    """Scenes, beside `splats`."""
    for capture in scenes(arguments):
        for count in arguments.frames:
            beside(capture, count)
            report(capture, count, "gaussians", steps=arguments.steps)


def settings(arguments: argparse.Namespace) -> None:
    """Scenes, one setting changed at a time."""
    for capture in scenes(arguments):
        for count in arguments.frames:
            for name, changed in VARIANTS.items():
                if not arguments.only or name in arguments.only:
                    report(capture, count, name, steps=arguments.steps, **changed)


def captures(arguments: argparse.Namespace) -> None:
    """Captures from disk, beside `splats`."""
    for folder in arguments.folders:
        capture = fsel.read_capture(folder, long_side=arguments.long_side)
        for count in arguments.frames:
            beside(capture, count)
            report(
                capture, count, "gaussians", steps=arguments.steps, gaussians=arguments.gaussians
            )


def presets(arguments: argparse.Namespace) -> None:
    """Every quality with thirty frames of a generated scene, or of captures on disk."""
    for name, quality in QUALITIES.items():
        if arguments.only and name not in arguments.only:
            continue
        side = quality.long_side
        for capture in [
            fsel.read_capture(folder, long_side=side) for folder in arguments.folders
        ] or [generated(FAMILIES[1], 2, side, FEW)]:
            report(capture, 30, f"{name}, {max(capture.size)} pixels", **quality.settings)


def scenes(arguments: argparse.Namespace) -> Iterator[Capture]:
    """The captures on disk that were asked for, else generated scenes."""
    for folder in arguments.folders:
        yield fsel.read_capture(folder, long_side=arguments.long_side)
    for seed in arguments.seeds if not arguments.folders else ():
        for family in arguments.families:
            yield generated(family, seed, arguments.width)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument(
        "what", choices=("speed", "twin", "quality", "settings", "captures", "presets")
    )
    parser.add_argument("folders", nargs="*", help="captures on disk")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--gaussians", type=int, default=20_000)
    parser.add_argument("--width", type=int, default=128, help="pixels, of generated scenes")
    parser.add_argument("--long-side", type=int, default=256, help="pixels, of captures on disk")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--families", nargs="+", default=FAMILIES, help="of generated scenes")
    parser.add_argument("--only", nargs="+", help="names of settings or presets")
    parser.add_argument(
        "--frames", type=lambda k: None if k == "all" else int(k), nargs="+", default=[30]
    )
    arguments = parser.parse_args()
    globals()[arguments.what](arguments)


if __name__ == "__main__":
    main()
