"""Time `fsel select` from a cold start: 30 of 300 frames.

A COLMAP capture of 300 images of 1920x1080 with 20,000 points is generated in a temporary folder.
Prints the wall time of the process, its parts by `selection.json`, each bound, and the processor
time, which a busy machine changes little. Run on a quiet machine:

    python benchmarks/command.py
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.model import build_model, write_model

FRAMES, SIZE, POINTS, SPAN = 300, (1920, 1080), 20_000, 30  # SPAN: frames that see a point
REPEATS = 5
BOUNDS = {"-k 30 --geometry-only": 1.0, "-k 30 --patience 0": 2.0}  # seconds by options


def write_capture(folder: Path) -> None:
    """An orbit with textured images; a point is seen by a stretch of frames."""
    rng = np.random.default_rng(0)
    xyz, start = rng.normal(size=(POINTS, 3)), rng.integers(0, FRAMES, POINTS)
    seen = [np.flatnonzero((i - start) % FRAMES < SPAN) for i in range(FRAMES)]
    turns = [cv2.Rodrigues(np.array([0, 2 * np.pi * i / FRAMES, 0]))[0] for i in range(FRAMES)]
    names = [f"{i:04d}.jpg" for i in range(FRAMES)]
    camera = Camera("PINHOLE", *SIZE, (SIZE[0], SIZE[0], SIZE[0] / 2, SIZE[1] / 2))
    model = build_model(
        names,
        [camera.colmap for _ in names],
        np.array([np.column_stack([turn, [0, 0, 4.0]]) for turn in turns]),
        xyz,
        np.zeros((POINTS, 3), np.uint8),
        seen,
        [rng.uniform(0, 1000, (len(rows), 2)) for rows in seen],
    )
    write_model(model, folder / "sparse" / "0")
    (folder / "images").mkdir()
    texture = cv2.resize(rng.integers(0, 255, (270, 480, 3), dtype=np.uint8), SIZE)
    for i, name in enumerate(names):
        shot = np.roll(texture, 13 * i, axis=1)
        cv2.imwrite(str(folder / "images" / name), shot, [cv2.IMWRITE_JPEG_QUALITY, 90])


def timed(capture: Path, out: Path, *options: str) -> dict[str, float]:
    """Seconds of one process, in all and by part."""
    command = [sys.executable, "-m", "fsel", "select", str(capture), "--quiet"]
    command += ["--max-error", "1e9"]  # the points that frames see are drawn at random
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    shutil.rmtree(out, ignore_errors=True)
    started, used = time.perf_counter(), cpu_seconds()
    subprocess.run([*command, "-o", str(out), *options], check=True, env=kept)
    wall, used = time.perf_counter() - started, cpu_seconds() - used
    parts = json.loads((out / "selection.json").read_text())["seconds"]
    return {"start": wall - parts.pop("total"), **parts, "total": wall, "processor": used}


def cpu_seconds() -> float:
    """Of all processes that have ended, on all cores together."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        capture = Path(folder, "capture")
        write_capture(capture)
        for options, limit in BOUNDS.items():
            runs = [timed(capture, Path(folder, "out"), *options.split()) for _ in range(REPEATS)]
            print(f"fsel select {options}")
            for part in runs[0]:
                bound = f"bound {limit:g} s" if part == "total" else ""
                print(f"  {part:10} {np.median([run[part] for run in runs]):7.3f} s  {bound}")


if __name__ == "__main__":
    main()
