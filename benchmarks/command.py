"""Time `fsel select` from a cold start: 30 of 300 frames, and 2,000 frames in six blocks.

COLMAP captures of 300 images of 1920x1080 with 20,000 points, and of 2,000 of 1280x720 with
400,000, are generated in a temporary folder. Prints the wall time of the process, its parts by
`selection.json`, each bound, and the processor time, which a busy machine changes little. Run on a
quiet machine:

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

BLOCKS, REPEATS = "-k 40 --blocks 6", 5
SCENES = {  # frames, their size, points, frames that see a point: bounds in seconds by options
    (300, (1920, 1080), 20_000, 30): {
        "-k 30 --geometry-only": 1.0,
        "-k 30 --patience 0": 2.0,
        "-k 30 --method sharpest": np.inf,
    },
    (2000, (1280, 720), 400_000, 12): {
        f"{BLOCKS} --geometry-only": 10.0,
        f"{BLOCKS} --patience 0": np.inf,
        BLOCKS: np.inf,
    },
}


def write_capture(folder: Path, frames: int, size: tuple, points: int, span: int) -> None:
    """An orbit with textured images; a point is seen by a stretch of frames."""
    rng = np.random.default_rng(0)
    xyz, start = rng.normal(size=(points, 3)), rng.integers(0, frames, points)
    seen = [np.flatnonzero((i - start) % frames < span) for i in range(frames)]
    turns = [cv2.Rodrigues(np.array([0, 2 * np.pi * i / frames, 0]))[0] for i in range(frames)]
    names = [f"{i:04d}.jpg" for i in range(frames)]
    camera = Camera("PINHOLE", *size, (size[0], size[0], size[0] / 2, size[1] / 2))
    model = build_model(
        names,
        [camera.colmap for _ in names],
        np.array([np.column_stack([turn, [0, 0, 4.0]]) for turn in turns]),
        xyz,
        np.zeros((points, 3), np.uint8),
        seen,
        [rng.uniform(0, 1000, (len(rows), 2)) for rows in seen],
    )
    write_model(model, folder / "sparse" / "0")
    (folder / "images").mkdir()
    texture = cv2.resize(rng.integers(0, 255, (270, 480, 3), dtype=np.uint8), size)
    for i, name in enumerate(names):
        shot = np.roll(texture, 13 * i, axis=1)
        cv2.imwrite(str(folder / "images" / name), shot, [cv2.IMWRITE_JPEG_QUALITY, 90])


def timed(capture: Path, out: Path, *options: str) -> dict[str, float]:
    """Seconds of one process, in all and, without blocks, by part."""
    command = [sys.executable, "-m", "fsel", "select", str(capture), "--quiet"]
    command += ["--max-error", "1e9"]  # the points that frames see are drawn at random
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    shutil.rmtree(out, ignore_errors=True)
    started, used = time.perf_counter(), cpu_seconds()
    subprocess.run([*command, "-o", str(out), *options], check=True, env=kept)
    wall, used = time.perf_counter() - started, cpu_seconds() - used
    record = out / "selection.json"
    parts = json.loads(record.read_text())["seconds"] if record.exists() else {"total": wall}
    return {"start": wall - parts.pop("total"), **parts, "total": wall, "processor": used}


def cpu_seconds() -> float:
    """Of all processes that have ended, on all cores together."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    for scene, bounds in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            capture = Path(folder, "capture")
            write_capture(capture, *scene)
            for options, limit in bounds.items():
                words = options.split()
                runs = [timed(capture, Path(folder, "out"), *words) for _ in range(REPEATS)]
                print(f"fsel select {options} ({scene[0]} frames)")
                for part in runs[0]:
                    bound = f"bound {limit:g} s" if part == "total" and limit < np.inf else ""
                    print(f"  {part:10} {np.median([run[part] for run in runs]):7.3f} s  {bound}")


if __name__ == "__main__":
    main()
