"""Memory and speed of reading a capture of 10,000 frames, the size of 7-Scenes' largest room.

Writes the capture (10 passes of 1,000 frames of 640x480, most of them links to a few images, so
that the disk holds it) and ingests it in a process of its own, with arrays streamed to disk. Prints
frames a second and the process's peak memory, and the same for a tenth of the frames: the
difference is what grows with the capture.

    python benchmarks/ingestion.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

PASSES, FRAMES, IMAGES, SIZE, LONG_SIDE = 10, 1000, 40, (640, 480), 256

READ = """
import logging, resource, sys, time
from fsel.stages.ingest import ingest
logging.basicConfig(level=logging.INFO, format="    %(message)s", stream=sys.stdout)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
started = time.perf_counter()
reading = {"layout": "seven_scenes"}
ingest(sys.argv[1], sys.argv[2], long_side=int(sys.argv[3]), at_least=50, reading=reading)
seconds = time.perf_counter() - started
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(f"{seconds:.1f} s, {int(sys.argv[4]) / seconds:.0f} frames a second, "
      f"peak memory {peak / 1024:.0f} MiB, {(peak - before) / 1024:.0f} above the imports")
"""


def write_capture(folder: Path, passes: int) -> None:
    """Passes through a corridor; images are links to a few files."""
    rng = np.random.default_rng(0)
    store = folder / "images"
    store.mkdir(parents=True)
    for i in range(IMAGES):
        coarse = rng.integers(0, 255, (60, 80, 3), dtype=np.uint8)
        image = cv2.resize(coarse, SIZE, interpolation=cv2.INTER_CUBIC)
        cv2.imwrite(str(store / f"{i}.png"), image, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    for p in range(1, passes + 1):
        home = folder / "scene" / f"seq-{p:02d}"
        home.mkdir(parents=True)
        for i in range(FRAMES):
            stem = home / f"frame-{i:06d}"
            os.link(store / f"{(i * passes + p) % IMAGES}.png", f"{stem}.color.png")
            pose = np.eye(4)
            pose[:3, 3] = [0.01 * i, 0.1 * p, 0]
            np.savetxt(f"{stem}.pose.txt", pose)
    names = [f"sequence{p}\n" for p in range(1, passes + 1)]
    (folder / "scene" / "TrainSplit.txt").write_text("".join(names[:-1]))
    (folder / "scene" / "TestSplit.txt").write_text(names[-1])


def main() -> None:
    for passes in (max(1, PASSES // 10), PASSES):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_capture(folder, passes)
            print(f"{passes * FRAMES} frames:")
            arguments = [str(folder / "scene"), str(folder / "out"), str(LONG_SIDE)]
            command = [sys.executable, "-c", READ, *arguments, str(passes * FRAMES)]
            subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
