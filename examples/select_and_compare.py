"""From a folder of posed images to the frames worth reconstructing from, and what they give.

fsel demo garden -o captures/garden                      # or a capture of your own
python examples/select_and_compare.py captures/garden 20
"""

import sys

import numpy as np

import fsel

folder, k = sys.argv[1], int(sys.argv[2])

# Poses and images, at the size that the CPU reconstructor is made for.
capture = fsel.read_capture(folder, long_side=96)
held_out = np.arange(0, len(capture), 8)
print(f"{len(capture)} frames, {len(held_out)} held out")

# The same request to several methods. `fsel` picks best first, so the first j are its picks at j.
for method in ("fsel", "nearest", "uniform"):
    chosen = fsel.select(capture, k, targets=held_out, method=method)
    model = fsel.fit(capture, chosen.indices)
    psnr = fsel.evaluate(capture, model, held_out)["psnr"].mean()
    print(f"{method:8} {psnr:6.2f} dB from {chosen.names[0]}, {chosen.names[1]}, ...")

# Without targets a selection serves all that the capture saw.
print("for any view:", ", ".join(fsel.select(capture, k).names))
