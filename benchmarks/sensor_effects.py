"""Which effect of the sensor limits how well `gaussians` can fit a generated scene.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/sensor_effects.py FAMILY...

A scene is filmed as its family is, then with one effect left out at a time, then without any; each
time 30 frames are fitted. PSNR on the training views, and on held-out frames.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from importlib import import_module

import numpy as np
from gaussians import fitted, generated, scores, split

from fsel.core.capture import Capture
from fsel.synthetic import sensor

recording = import_module("fsel.synthetic.record")  # its function has the module's name
LEFT_OUT: dict[str, tuple[str, ...]] = {
    "as filmed": (),
    "no noise": ("noise",),
    "no exposure drift": ("drift",),
    "no vignette": ("vignette",),
    "no blur": ("blur",),
    "none of them": ("noise", "drift", "vignette", "blur"),
}


def filmed(family: str, seed: int, without: tuple[str, ...], width: int = 128) -> Capture:
    """The recording of 160 frames, four by three, as a capture, without some effects."""
    plan, vignette = recording.clear_shot, sensor.VIGNETTE

    def changed(*arguments):
        made, caster, rng = plan(*arguments)
        habits, exposure, passes = made.habits, made.exposure, made.passes
        if "noise" in without:
            habits = replace(habits, noise=0.0)
        if "drift" in without:
            exposure = np.ones_like(exposure)
        if "blur" in without:
            habits = replace(habits, shutter=0.0)
            passes = tuple((path, s, np.zeros_like(shake)) for path, s, shake in passes)
        return replace(made, habits=habits, exposure=exposure, passes=passes), caster, rng

    recording.clear_shot = changed
    sensor.VIGNETTE = 0.0 if "vignette" in without else vignette
    try:
        return generated(family, seed, width)
    finally:
        recording.clear_shot, sensor.VIGNETTE = plan, vignette


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("families", nargs="+")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--gaussians", type=int, default=20_000)
    options = parser.parse_args()
    for family in options.families:
        for name, without in LEFT_OUT.items():
            capture = filmed(family, options.seed, without)
            frames, held_out = split(capture, 30)
            model, seconds = fitted(
                capture, frames, steps=options.steps, gaussians=options.gaussians
            )
            within = scores(model, capture, frames)[0]
            beyond = scores(model, capture, held_out)[0]
            print(
                f"{family} {options.seed}, {name}: training {within:.2f} dB, held-out "
                f"{beyond:.2f} dB, {seconds:.0f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
