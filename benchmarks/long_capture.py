"""`fsel select` from 50,000 frames: seconds, memory and the size of the report.

A transforms.json of 50,000 frames along a street, with JPEG files of 640x480 that are links to 40
different ones. Prints the bytes of a file; then, for each way to ask, the wall time of the process,
its processor time, its peak memory and the bytes of report.html, beside the bounds.

    python benchmarks/long_capture.py
    python benchmarks/long_capture.py --frames 10000
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

FRAMES, IMAGES, SIZE, K = 50_000, 40, (640, 480), 50
NOISE = 3.0  # grey levels, of a sensor: what most bytes of a JPEG go to
GEOMETRY = ("--geometry-only",)
BOUNDS = {
    GEOMETRY: (20, 1200),
    ("--patience", "0"): (None, 1200),
    ("--method", "sharpest"): (60, 1200),
}
"""Options -> most seconds and MB of memory; the report is to take 3 MB at most."""
REPORT = 3_000_000  # bytes


def photograph(rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 with detail at every scale, finer detail being fainter, and noise."""
    width, height = SIZE
    total = np.zeros((height, width, 3), np.float32)
    for cells in 2 ** np.arange(2, 9):
        coarse = rng.normal(size=(cells * height // width, cells, 3)).astype(np.float32)
        total += cv2.resize(coarse, SIZE, interpolation=cv2.INTER_CUBIC) / cells
    total = 255 * (total - total.min()) / np.ptp(total) + rng.normal(scale=NOISE, size=total.shape)
    return np.clip(total, 0, 255).astype(np.uint8)


def write_capture(folder: Path, count: int) -> None:
    """Cameras along a winding street."""
    (folder / "images").mkdir(parents=True)
    rng = np.random.default_rng(0)
    for i in range(min(IMAGES, count)):
        quality = [cv2.IMWRITE_JPEG_QUALITY, 92]
        cv2.imwrite(str(folder / f"{i}.jpg"), photograph(rng), quality)
    print(f"{(folder / '0.jpg').stat().st_size:,} bytes an image")
    frames = []
    for i in range(count):
        name = f"images/{i:06d}.jpg"
        os.link(folder / f"{i % IMAGES}.jpg", folder / name)
        pose = np.eye(4)
        pose[:3, :3] = cv2.Rodrigues(np.array([0, 0.5 * np.sin(i / 300), 0]))[0]
        pose[:3, 3] = [20 * np.sin(i / 5000), 0.1 * np.sin(i / 7), -0.02 * i]
        frames.append({"file_path": name, "transform_matrix": pose.tolist()})
    width, height = SIZE
    camera = {"w": width, "h": height, "fl_x": 500, "fl_y": 500, "cx": width / 2, "cy": height / 2}
    (folder / "transforms.json").write_text(json.dumps({**camera, "frames": frames}))


def measured(capture: Path, out: Path, options: tuple[str, ...]) -> tuple[float, float, float]:
    """Wall and processor seconds of one process, and its peak memory in MB."""
    command = [sys.executable, "-m", "fsel", "select", str(capture), "-k", str(K), "--quiet"]
    started = time.perf_counter()
    process = subprocess.Popen([*command, "-o", str(out), "--force", *options])
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{command} {options} ended with {status}")
    spent = usage.ru_utime + usage.ru_stime
    return time.perf_counter() - started, spent, usage.ru_maxrss / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=FRAMES)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        capture, out = Path(name, "capture"), Path(name, "out")
        write_capture(capture, arguments.frames)
        for options, (seconds, memory) in BOUNDS.items():
            wall, spent, peak = measured(capture, out, options)
            size = (out / "report.html").stat().st_size
            parts = json.loads((out / "selection.json").read_text())["seconds"]
            print(" ".join(["fsel select", *options]), f"({arguments.frames:,} frames, K = {K})")
            print(f"  {wall:.1f} s, bound {seconds}; {spent:.1f} s of the processor; {parts}")
            print(
                f"  {peak:.0f} MB, bound {memory}; report {size:,} bytes, bound {REPORT:,}",
                flush=True,
            )


if __name__ == "__main__":
    main()
