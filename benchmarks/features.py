"""Features for poses, SIFT's and networks': frames placed, errors, seconds of the processor.

    OMP_NUM_THREADS=1 python benchmarks/features.py CAPTURE... --frames 24 --step 3 --dim 1 0.2 0.06

Every so many frames of captures are placed as those of a video are. `fixed` is SIFT whose threshold
does not follow the images' contrast. `--dim` multiplies the light,
with the noise of a sensor (2 grey levels) and 8 bits after it. Errors are against the captures' own
poses after the best similarity: median (greatest) degrees, and of centres per cent of the scene.
`again` is what another seed gives: frames that are placed, and degrees between both sets of poses.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fsel.captures.colmap import features, runs
from fsel.captures.colmap.runs import Part, Work
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.poses import sfm
from fsel.captures.poses.agreement import pose_errors
from fsel.captures.poses.placement import repeated
from fsel.captures.read import read_raw

NOISE = 2.0
LIT = {"fixed": 0, **dict.fromkeys(features.KINDS, runs.LIT)}


def dimmed(raw: RawCapture, folder: Path, dim: float) -> RawCapture:
    """The capture with images of less light, in a folder."""
    if dim == 1:
        return raw
    rng, files = (
        np.random.default_rng(0),
        [folder / f"{at:04d}.png" for at in range(len(raw.names))],
    )
    for image, file in zip(raw.images, files, strict=True):
        bright = image_files.load(image) * dim
        dark = np.clip(bright + rng.normal(0, NOISE, bright.shape), 0, 255).astype(np.uint8)
        image_files.write(dark[None], folder, [file.name])
    return replace(raw, images=files)


def measured(raw: RawCapture, kind: str) -> str:
    """Cells of a table: frames that are placed, their errors, and seconds."""
    started = time.process_time()
    runs.LIT, used = LIT[kind], features.SIFT if kind == "fixed" else kind
    part = Part(range(len(raw.names)), ordered=True)
    try:
        with TemporaryDirectory() as folder:
            work = Work(Path(folder), parts=[part], features=used)
            model = sfm.place(raw, work=work)
            seconds = time.process_time() - started
            again = repeated(model, work)
        found = sfm.with_model(raw, model, "not placed")
        given = raw.world_to_camera[[raw.names.index(name) for name in found.names]]
        errors = pose_errors(found.world_to_camera, given)
    except ValueError:  # none is placed, or three on a line
        return f"0 of {len(raw.names)} | | | {time.process_time() - started:.0f} |"
    told = " | ".join(f"{np.median(error):.2f} ({error.max():.2f})" for error in errors)
    return f"{len(found.names)} of {len(raw.names)} | {told} | {seconds:.0f} | {again}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("captures", type=Path, nargs="+")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--step", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=LIT, default=list(LIT))
    parser.add_argument("--dim", type=float, nargs="+", default=[1.0], help="factors of the light")
    options = parser.parse_args()
    print("| capture | light | features | placed | degrees | centres, % | s | again |")
    print("|---|---|---|---|---|---|---|---|")
    for source in options.captures:
        _, raw = read_raw(source)
        frames = range(options.first, len(raw.names), options.step)[: options.frames]
        raw = raw.subset(list(frames), "")
        for dim in options.dim:
            with TemporaryDirectory() as folder:
                seen = dimmed(raw, Path(folder), dim)
                for kind in options.kinds:
                    cells = measured(seen, kind)
                    print(f"| {source.name} | {dim:g} | {kind} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
