"""A held-out view beside what every n-th frame and the picks of fsel show of it.

python examples/side_by_side.py                                 # a generated capture, minutes
python examples/side_by_side.py --capture captures/garden --targets 30:60:4 -k 12

Frames FROM:TO:STEP of the capture are held out: they are the views to be rendered. Both selections
have as many frames, and each is reconstructed by 3D Gaussians on the CPU. The view that is shown is
the one whose gain is the median. The generated capture needs the extra `demo`.
"""

import argparse
import tempfile
from pathlib import Path

import cv2
import numpy as np

import fsel
from fsel.data.capture import Capture

METHODS = {"uniform": "every n-th frame", "fsel": "fsel"}
SCENE = ("tanks_and_temples", 2)  # family and seed of the generated capture
BAR = 30  # pixels of the captions


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Every n-th frame beside the picks of fsel.")
    parser.add_argument("--capture", help="a folder that fsel reads; a generated one by default")
    parser.add_argument("--targets", default="30:60:4", help="the frames held out: FROM:TO:STEP")
    parser.add_argument("-k", type=int, default=12, help="frames to select")
    parser.add_argument("--long-side", type=int, default=384, help="pixels")
    parser.add_argument("--steps", type=int, default=1500, help="of the optimisation")
    parser.add_argument("--gaussians", type=int, default=25_000, help="3D Gaussians at most")
    parser.add_argument("--picture", type=Path, default=Path("side_by_side.jpg"), help="to write")
    return parser.parse_args()


def generated(long_side: int) -> Capture:
    """Film 120 frames of a generated scene."""
    from fsel.layouts import colmap
    from fsel.synthesis import record

    with tempfile.TemporaryDirectory() as folder:
        colmap.write(record(*SCENE, 120, long_side, long_side * 3 // 4), Path(folder))
        return fsel.read_capture(folder, long_side=long_side)


def captioned(image: np.ndarray, caption: str) -> np.ndarray:
    """Write a caption on a white bar above an (h, w, 3) RGB image in 0..255."""
    bar = np.full((BAR, image.shape[1], 3), 255, np.uint8)
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.55
    cv2.putText(bar, caption, (6, BAR - 10), font, size, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([bar, image])


given = arguments()
if given.capture:
    capture = fsel.read_capture(given.capture, long_side=given.long_side)
else:
    capture = generated(given.long_side)
targets = np.arange(len(capture))[slice(*map(int, given.targets.split(":")))]
print(f"{len(capture)} frames, {len(targets)} held out, {given.k} to select")

views, psnr = {}, {}
for method, label in METHODS.items():
    picks = fsel.select(capture, given.k, targets=targets, method=method).indices
    model = fsel.fit(capture, picks, "gaussians", steps=given.steps, gaussians=given.gaussians)
    views[method] = model.render(capture.view(targets))
    psnr[method] = fsel.evaluate(capture, model, targets)["psnr"]
    print(f"{label}: {psnr[method].mean():.2f} dB, frames {sorted(picks.tolist())}")

gain = psnr["fsel"] - psnr["uniform"]
shown = np.argsort(gain)[len(gain) // 2]
print(f"shown: frame {capture.names[targets[shown]]}, {gain[shown]:+.2f} dB")
parts = [captioned(capture.images[targets[shown]], "held-out view")]
for method, label in METHODS.items():
    image = np.rint(np.clip(views[method][shown], 0, 1) * 255).astype(np.uint8)
    parts.append(captioned(image, f"{label}, K = {given.k}: {psnr[method][shown]:.1f} dB"))
cv2.imwrite(str(given.picture), np.hstack(parts)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
