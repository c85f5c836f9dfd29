"""How the page of `fsel view` draws a model, beside the library, in Chromium with software WebGL.

    python benchmarks/viewer.py MODEL.ply=CAPTURE... --long-side 480

Prints for each model its Gaussians, the page's megabytes, the seconds until the whole splat is
drawn, and the PSNR of the page's picture against the library's rendering at five cameras.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import fsel
from fsel.core.subsets import evenly
from fsel.metrics import score_views
from fsel.pages import viewer
from fsel.reconstruct import ply
from fsel.reconstruct.gaussians import GaussianModel

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))


def main() -> None:
    from splat_pages import drawn

    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("pairs", nargs="+", metavar="MODEL=CAPTURE")
    parser.add_argument("--long-side", type=int, default=480, help="pixels")
    arguments = parser.parse_args()
    for pair in arguments.pairs:
        file, folder = pair.split("=")
        capture = fsel.read_capture(folder, long_side=arguments.long_side)
        frames, model = evenly(len(capture), 5), GaussianModel.read_ply(file)
        cameras = [viewer.ViewerCamera(name, "frame") for name in capture.names]
        page = viewer.page(file, viewer.scene(capture, cameras, ply.read(file)))
        with tempfile.TemporaryDirectory() as place:
            pictures, seconds = drawn(page, capture.size, frames, Path(place))
        rendered = np.rint(model.render(capture.view(frames)) * 255).astype(np.uint8)
        psnr = score_views(pictures.astype(np.float32) / 255, rendered, None, ("psnr",))[:, 0]
        print(
            f"{Path(file).name}: {model.primitives} Gaussians, {len(page) / 1e6:.1f} MB without "
            f"photos, first picture after {seconds:.1f} s, PSNR {psnr.min():.1f} to "
            f"{psnr.max():.1f} dB, mean {psnr.mean():.1f} dB at {len(frames)} cameras",
            flush=True,
        )


if __name__ == "__main__":
    main()
