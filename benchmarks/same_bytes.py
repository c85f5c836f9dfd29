"""Digests of what each part of the system computes, to compare between processors.

    python benchmarks/same_bytes.py                                     # on this processor
    qemu-x86_64 -cpu Haswell .venv/bin/python benchmarks/same_bytes.py  # on one with AVX2 alone

Both set the variables of the workflow's jobs (`fsel.workflow.machine`). A line has the part, and
the first digits of the sha256 of its arrays. Families of scenes and `network` may be named; under
emulation all of it takes an hour, `network` some minutes.
"""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

from fsel.workflow.machine import PINNED

FAMILIES = ("scannet", "mipnerf360")
NETWORK = "network"
SETTINGS = {
    "splats": {},
    "gaussians": {"steps": 15, "gaussians": 500},
    "radiance_field": {"steps": [3, 3, 3], "rays": 256},
}


def told(part: str, *arrays) -> None:
    """Print the digest of some arrays."""
    import numpy as np

    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    print(f"{part:28} {digest.hexdigest()[:12]}", flush=True)


def scene(family: str) -> None:
    """Film, describe, select and reconstruct."""
    import numpy as np

    from fsel.core.capture import Capture
    from fsel.core.points import SparsePoints
    from fsel.features.appearance import LAB_HOG, descriptors
    from fsel.metrics import score_views
    from fsel.reconstruct import reconstructor_of
    from fsel.selection.api import select
    from fsel.synthetic import record

    made = record(family, 1, frames=24, width=64, height=48)
    told(f"{family}: capture", made.images, made.depth, made.xyz, made.world_to_camera)
    points = SparsePoints(made.xyz, made.rgb, made.track_point, made.track_frame)
    intrinsics = np.tile(made.camera.params, (24, 1))
    poses = made.world_to_camera
    capture = Capture(made.names, poses, intrinsics, made.images, made.sequences, points)
    told(f"{family}: descriptors", descriptors(made.images, LAB_HOG))
    for method in ("less_is_more", "fsel", "kmedoids"):
        told(f"{family}: {method}", select(capture, 8, targets="every:6", method=method).indices)
    fed, seen = np.arange(0, 24, 3), np.arange(1, 24, 6)
    for name, settings in SETTINGS.items():
        section = {"name": name, "long_side": 64, "settings": settings}
        reconstructor = reconstructor_of(capture, section)
        images = reconstructor.fit(fed).render(reconstructor.capture.view(seen))
        scores = score_views(images, made.images[seen], None, ("psnr", "ssim", "gmsd"))
        told(f"{family}: {name}", images, scores)


def network() -> None:
    """Train the paper's network."""
    import numpy as np

    from fsel.training.imitation import Trajectory, train

    rng = np.random.default_rng(0)
    shown = rng.normal(size=(20, 6, 20, 19)).astype(np.float32)
    items = [Trajectory(one, np.ones((6, 20), bool), one[:, :, 4].argmax(1), 1.0) for one in shown]
    weights, _ = train(items, items[:2], seed=0, epochs=2, learning_rate=1e-3)
    told(NETWORK, *weights.values())


if __name__ == "__main__":
    cache = str(Path(".numba", "same_bytes").resolve())
    os.environ |= PINNED | {
        "NUMBA_CACHE_DIR": cache,
        "OMP_NUM_THREADS": "1",
    }  # before NumPy's import
    for part in sys.argv[1:] or (*FAMILIES, NETWORK):
        network() if part == NETWORK else scene(part)
