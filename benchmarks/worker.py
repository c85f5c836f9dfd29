"""What the protocol of a worker costs: milliseconds a subset beyond the worker's own.

    python benchmarks/worker.py

A worker that returns noise: 20 frames go out and 15 views come back, at 64x48 and 960x540 pixels.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from radiance_field import generated

from fsel.reconstruct.external import External

K, VIEWS, TIMES = 20, 15, 200
NOISE = """
import numpy as np
from fsel_worker import serve

noise = {}

def render(model, views):
    if views.size not in noise:
        shape = (len(views), views.size[1], views.size[0], 3)
        noise[views.size] = np.random.default_rng(0).random(shape, dtype=np.float32)
    return noise[views.size]

serve(lambda subset: None, render, name="noise")
"""


def main() -> None:
    """Print a line a size."""
    for size in ((64, 48), (960, 540)):
        served = External(generated("mipnerf360", 0, size), serve=[sys.executable, "-c", NOISE])
        views = served.capture.view(np.arange(VIEWS))
        taken = []
        for at in range(TIMES):
            started = time.perf_counter()
            served.fit(VIEWS + (np.arange(K) + at) % (2 * K)).render(views)
            taken.append((time.perf_counter() - started) * 1e3)
        median, late = np.percentile(taken[10:], [50, 95])
        print(f"{size[0]}x{size[1]}: {median:.1f} ms a subset, 95 % below {late:.1f} ms")


if __name__ == "__main__":
    main()
