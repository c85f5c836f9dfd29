"""Seconds, memory and PSNR of every reconstructor on one scene.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/reconstructors.py splats gaussians ...
    ... python benchmarks/reconstructors.py recipe.yaml...

Each argument is a name of `fsel.reconstruct.RECONSTRUCTORS` with its default settings, or a file
with a `reconstruction`, such as those of config/reconstructors. A generated scene of the family
Mip-NeRF 360; 20 frames to reconstruct from, 4 held out. A process of its own for each. Seconds are
the processor's, with those of the programs that were started; memory is what the model states.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import yaml
from radiance_field import generated, psnr

from fsel.reconstruct import check_needs, reconstructor_of

SIZE = (64, 48)


def processor_seconds() -> float:
    """Of this process and of all that it started and that ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def section_of(name: str) -> dict:
    """A reconstructor as a config names it."""
    if not name.endswith(".yaml"):
        return {"name": name, "settings": {}, "long_side": SIZE[0]}
    section = yaml.safe_load(Path(name).read_text())["reconstruction"]
    return {"settings": {}, **section, "long_side": SIZE[0]}


def measure(section: dict) -> dict[str, float | str]:
    """A fit after one that is not counted, which compiles; a program is started once."""
    check_needs(section)
    capture = generated("mipnerf360", 0, SIZE)
    held, frames = np.arange(4, 160, 40), np.arange(0, 160, 8)
    reconstructor = reconstructor_of(capture, section)
    first = 0  # memory is new in the first fit alone
    if section["name"] != "external":
        model = reconstructor.fit(frames)
        model.render(capture.view(held))
        first = model.peak_bytes
    started = processor_seconds()
    model = reconstructor_of(capture, section).fit(frames)
    fitted = processor_seconds()
    value = psnr(model, capture, held)
    return {
        "fit": fitted - started,
        "view": (processor_seconds() - fitted) / len(held),
        "memory": max(first, model.peak_bytes) / 1e6,
        "psnr": value,
        "device": model.device,
    }


def main() -> None:
    """Print a row a reconstructor."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="+")
    parser.add_argument("--one", action="store_true", help="measure here, and print JSON")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(section_of(options.names[0]))))
        return
    print("| reconstructor | fit, s | a view, s | peak memory, MB | PSNR, dB | device |")
    print("|---|---|---|---|---|---|")
    for name in options.names:
        done = subprocess.run(
            [sys.executable, __file__, "--one", name], stdout=subprocess.PIPE, check=True, text=True
        )
        row = json.loads(done.stdout.splitlines()[-1])
        cells = [f"{row['fit']:.1f}", f"{row['view']:.2f}", f"{row['memory']:.0f}"]
        print(f"| {name} | {' | '.join(cells)} | {row['psnr']:.2f} | {row['device']} |", flush=True)


if __name__ == "__main__":
    main()
