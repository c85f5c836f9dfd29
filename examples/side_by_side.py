"""A flight between held-out views, through uniformly sampled frames and the picks of fsel.

python examples/side_by_side.py                                 # a generated capture, minutes
python examples/side_by_side.py --capture captures/garden --targets 30:60:4 -k 12

Frames FROM:TO:STEP of the capture are held out: they are the views to be rendered. Both selections
have as many frames, and each is reconstructed by 3D Gaussians on the CPU; the captions show
their mean PSNR at the held-out views.
"""

import argparse
import tempfile
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

import fsel
from fsel.captures.images.video import levels
from fsel.cli.render import flight
from fsel.core.capture import Capture

METHODS = {"uniform": "uniform sampling", "fsel": "fsel"}
SCENE = ("tanks_and_temples", 2)  # family and seed of the generated capture
RATE = 12  # pictures a second


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Uniform samples beside the picks of fsel.")
    parser.add_argument("--capture", help="a folder that fsel reads; a generated one by default")
    parser.add_argument("--targets", default="30:60:4", help="the frames held out: FROM:TO:STEP")
    parser.add_argument("-k", type=int, default=12, help="frames to select")
    parser.add_argument("--long-side", type=int, default=384, help="pixels")
    parser.add_argument("--steps", type=int, default=1500, help="of the optimisation")
    parser.add_argument("--gaussians", type=int, default=25_000, help="3D Gaussians at most")
    parser.add_argument("--pictures", type=int, default=60, help="of the clip")
    parser.add_argument("--clip", type=Path, default=Path("side_by_side.webp"), help="to write")
    return parser.parse_args()


def generated(long_side: int) -> Capture:
    """Film 120 frames of a generated scene."""
    from fsel.captures.layouts import colmap
    from fsel.synthetic import record

    with tempfile.TemporaryDirectory() as folder:
        colmap.write(record(*SCENE, 120, long_side, long_side * 3 // 4), Path(folder))
        return fsel.read_capture(folder, long_side=long_side)


def captioned(image: np.ndarray, caption: str) -> np.ndarray:
    """Return an image below a white bar with a caption."""
    bar = np.full((24, image.shape[1], 3), 255, np.uint8)
    cv2.putText(bar, caption, (5, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.44, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([bar, image])


given = arguments()
if given.capture:
    capture = fsel.read_capture(given.capture, long_side=given.long_side)
else:
    capture = generated(given.long_side)
targets = np.arange(len(capture))[slice(*map(int, given.targets.split(":")))]
print(f"{len(capture)} frames, {len(targets)} held out, {given.k} to select")

views = flight(capture, targets, given.pictures, given.long_side)
panels = []
for method, label in METHODS.items():
    picks = fsel.select(capture, given.k, targets=targets, method=method).indices
    model = fsel.fit(capture, picks, "gaussians", steps=given.steps, gaussians=given.gaussians)
    psnr = fsel.evaluate(capture, model, targets)["psnr"].mean()
    print(f"{label}: {psnr:.2f} dB, frames {sorted(picks.tolist())}")
    caption = f"{label}, K = {given.k}: {psnr:.1f} dB"
    panels.append([captioned(levels(image), caption) for image in model.render(views)])

pictures = [Image.fromarray(np.hstack(pair)) for pair in zip(*panels, strict=True)]
there_and_back = pictures + pictures[-2:0:-1]
there_and_back[0].save(
    given.clip,
    save_all=True,
    append_images=there_and_back[1:],
    duration=1000 // RATE,
    loop=0,
    quality=70,
    method=6,
)
print(f"{given.clip}: {given.clip.stat().st_size / 1e6:.1f} MB")
