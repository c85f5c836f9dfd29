"""Kills by SIGKILL at random moments: `PYTHONPATH=src:tests python -m fuzz.kills --kills 100`.

`fsel select --force` is killed, and its output compared with that of a run that nobody killed.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from small_captures import write_ring

SELECT = ["-m", "fsel", "select", "ring", "-k", "6", "--quiet", "--patience", "0", "-o", "out"]


def main():
    """Kill, and say what was found: the exit code is 1 if anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m fuzz.kills")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        wrong = killed(Path(name), asked.kills, random.Random(asked.seed))
    sys.exit(int(wrong > 0))


def killed(folder, kills, rng):
    """How many outputs were missing, half or other, or were left beside it."""
    write_ring(folder / "ring", frames=24)
    line = [sys.executable, *SELECT, "--force"]
    subprocess.run(line, cwd=folder, check=True)
    started = time.monotonic()
    subprocess.run(line, cwd=folder, check=True)
    whole, took = contents(folder / "out"), time.monotonic() - started
    differing = 0
    for _ in range(kills):
        process = subprocess.Popen(line, cwd=folder, stderr=subprocess.DEVNULL)
        try:
            process.wait(rng.uniform(0.1, 0.9) * took)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        differing += contents(folder / "out") != whole
    subprocess.run(line, cwd=folder, check=True)
    left = {path.name for path in folder.iterdir()} - {"ring", "out"}
    print(f"{kills} kills; {differing} outputs missing or other; {left=}")
    return differing + len(left)


def contents(folder):
    """Bytes of each file but the record, which has times."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "selection.json"]
    return {path.relative_to(folder): path.read_bytes() for path in files}


if __name__ == "__main__":
    main()
