"""What each `--quality` of the reconstructor `gaussians` takes and brings.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/gaussians.py [FOLDER...]
    ... python benchmarks/gaussians.py --only draft good

On a generated scene, or on captures from disk, with FSEL_THREADS threads or one for each core.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from reconstructors import generated, scores

import fsel
from fsel.core.capture import Capture
from fsel.reconstruct import Model
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.gaussians.settings import QUALITIES

FEW = 60  # frames of large images, which take long to generate


def split(capture: Capture, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`count` evenly spaced frames, and every twelfth frame, which is held out."""
    held_out = np.arange(3, len(capture), 12)
    rest = np.setdiff1d(np.arange(len(capture)), held_out)
    return rest[np.linspace(0, len(rest) - 1, count).astype(int)], held_out


def report(capture: Capture, count: int, name: str, bound) -> None:
    """Fit, and print scores on training and held-out frames."""
    frames, held_out = split(capture, count)
    start, began = time.process_time(), time.perf_counter()
    model: Model = bound.fit(frames)
    seconds, waited = time.process_time() - start, time.perf_counter() - began
    within = scores(model, capture, frames[:: max(1, len(frames) // 10)])
    beyond = scores(model, capture, held_out)
    print(
        f"{capture.source}, K = {len(frames)}, {name}: held-out PSNR {beyond[0]:.2f} SSIM "
        f"{beyond[1]:.3f} GMSD {beyond[2]:.3f}, training PSNR {within[0]:.2f}, "
        f"{model.primitives} primitives, {waited:.0f} s, {seconds:.0f} s of the "
        f"processor, peak {model.peak_bytes / 2**20:.0f} MiB",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folders", nargs="*", help="captures on disk")
    parser.add_argument("--only", nargs="+", default=list(QUALITIES), help="names of presets")
    arguments = parser.parse_args()
    for name in arguments.only:
        one = QUALITIES[name]
        read = [fsel.read_capture(f, long_side=one.long_side) for f in arguments.folders]
        for capture in read or [generated("tanks_and_temples", 2, one.long_side, FEW)]:
            label = f"{name}, {max(capture.size)} pixels"
            report(capture, 30, label, Gaussians(capture, **one.settings))


if __name__ == "__main__":
    main()
