"""Frames that a program places in captures with poses, how far off, and its seconds.

    python benchmarks/pose_programs.py CAPTURE... [--by COMMAND...]

COMMAND is as of `fsel poses`; without it COLMAP's mapper is measured as `fsel poses` runs it.
Errors are medians (greatest) after the best similarity; of centres in per cent of the scene's size.
"""

from __future__ import annotations

import argparse
import shlex
import time

import numpy as np

from fsel.captures.colmap.estimator import checked
from fsel.captures.colmap.runs import Work
from fsel.captures.poses import sfm
from fsel.captures.poses.agreement import pose_errors
from fsel.captures.read import read_raw
from fsel.core.limits import cores


def main() -> None:
    """Print a line a capture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("captures", nargs="+")
    parser.add_argument("--by", action="append")
    args = parser.parse_args()
    by = checked({"by": [shlex.split(line) for line in args.by]}) if args.by else None
    for capture in args.captures:
        _, raw = read_raw(capture)
        started = time.perf_counter()
        found = sfm.reconstruct(raw, work=Work(threads=cores(), by=by))
        seconds = time.perf_counter() - started
        given = raw.world_to_camera[[raw.names.index(name) for name in found.names]]
        degrees, percent = pose_errors(found.world_to_camera, given)
        print(
            f"{capture}: {len(found.names)} of {len(raw.names)} frames, "
            f"{np.median(degrees):.2f} ({degrees.max():.2f}) degrees, "
            f"{np.median(percent):.2f} ({percent.max():.2f}) per cent, {seconds:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
