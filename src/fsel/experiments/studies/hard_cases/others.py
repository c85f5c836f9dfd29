"""Hard images, and scenes to reconstruct."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from fsel.captures.images.previews import sharpness
from fsel.core.capture import Capture
from fsel.core.geometry import pixel_rays
from fsel.core.points import SparsePoints
from fsel.experiments.studies.hard_cases import Case, CaseOutcome, finite, quality, worlds
from fsel.features.appearance import descriptors
from fsel.metrics import score_views
from fsel.metrics.fused import PSNR_CEILING
from fsel.reconstruct.splats import Splats

SHAPE = (3, 24, 32, 3)
EXPECTED = "sharpness 0; a unit descriptor, none for black; SSIM 1 and GMSD 0 with itself"
DEPTH = 4.0
SHARE = 20  # one point in so many lies at the odd depth
# of the wall's depth: the gap between two depth planes there. The last bits of the matching costs
# decide between neighbouring planes, and they differ between processors: the median error is
# 0.017 where vectors hold eight float32, 0.022 where they hold sixteen
PLANE = 0.027


def blank(level: int) -> CaseOutcome:
    """A uniform image has no sharpness, a descriptor of length one (black: none), and is itself."""
    images = np.full(SHAPE, level, np.uint8)
    sharp, described = sharpness(images), descriptors(images, "lab_hog")
    scores = score_views((images / np.float32(255)).astype(np.float32), images)
    finite(sharp, described, scores)
    length = np.linalg.norm(described.astype(np.float64), axis=1)
    off = (sharp, length - (level > 0), scores[:, 1] - 1, scores[:, 2])
    error = max(np.abs(values).max() for values in off)
    observed = f"sharpness {sharp[0]:.2g}; descriptor {length[0]:.6f}; PSNR {scores[0, 0]:.1f} dB"
    return CaseOutcome(observed, float(error) if scores[0, 0] >= PSNR_CEILING else np.inf, 1e-6)


def wall(depth: float, odd: float | None = None) -> Capture:
    """Twelve cameras abreast before a painted plane, with points on it and, optionally, elsewhere;
    baselines and paint are in proportion to its depth."""
    n, count = 12, 200
    place = np.zeros((n, 3))
    place[:, 0] = (np.arange(n) - n / 2) * 0.25 * depth / DEPTH
    camera = np.array([40.0, 40.0, 24.0, 18.0])
    seen = pixel_rays(camera, 48, 36) + place[:, None, None] / depth
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(-1, 1, (count, 2)) * depth / 3, np.full(count, depth)])
    if odd is not None:
        xyz[::SHARE] *= odd / depth
    tracks = np.tile(np.arange(count), n), np.repeat(np.arange(n), count)
    return Capture(
        names=tuple(f"{i:02d}" for i in range(n)),
        world_to_camera=worlds.poses(place, np.tile([0.0, 0.0, 1.0], (n, 1))),
        intrinsics=np.tile(camera, (n, 1)),
        images=worlds.paint(seen),
        sequences=("a",) * n,
        points=SparsePoints(xyz, np.zeros((count, 3), np.uint8), *tracks),
    )


def measure_quality(capture: Capture) -> tuple[float, float]:
    """Measure PSNR in dB of every fourth frame from the others, and the median depth error."""
    targets = np.arange(1, len(capture), 4)
    frames = np.setdiff1d(np.arange(len(capture)), targets)
    position = Splats(capture).fit(frames).positions
    finite(position)
    assert capture.points is not None  # `wall` gives them
    depth = np.median(capture.points.xyz[:, 2])
    return quality(capture, frames, targets), float(np.median(np.abs(position[:, 2] / depth - 1)))


def of_depth(depth: float, odd: float | None, allowed: float) -> CaseOutcome:
    """Depth error of the wall; PSNR against the same wall with all points on it."""
    usual, _ = measure_quality(wall(DEPTH))
    psnr, error = measure_quality(wall(depth, odd))
    observed = f"PSNR {psnr:.2f} dB, plain wall {usual:.2f}"
    return CaseOutcome(observed, error, allowed, usual - psnr)


def turned_about() -> CaseOutcome:
    """Two walls back to back: no frame of one half sees anything of the other's."""
    first = wall(DEPTH)
    back = np.diag([-1.0, 1.0, -1.0])
    second = first.world_to_camera.copy()
    second[:, :, :3] = second[:, :, :3] @ back
    both = replace(
        first,
        names=(*first.names, *(f"b{name}" for name in first.names)),
        world_to_camera=np.concatenate([first.world_to_camera, second]),
        intrinsics=np.tile(first.intrinsics, (2, 1)),
        images=np.tile(first.images, (2, 1, 1, 1)),
        sequences=first.sequences * 2,
        points=None,
    )
    half = np.array([2, 3, 4, 6, 7])
    several = (half, np.append(half, half + 12))
    alone, together = (quality(both, frames, np.array([5])) for frames in several)
    observed = f"PSNR {alone:.2f} dB, with the other side's frames {together:.2f}"
    return CaseOutcome(observed, float(abs(together - alone)), 0.01, alone - together)


CASES = (
    *(
        Case(f"{name} images", EXPECTED, partial(blank, level))
        for name, level in (("black", 0), ("uniform grey", 119), ("white", 255))
    ),
    Case("a scene with one depth", "that depth", lambda: of_depth(DEPTH, None, PLANE)),
    Case("a scene at depth 1e-4", "that depth", lambda: of_depth(1e-4, None, PLANE)),
    Case("a scene at depth 1e6", "that depth", lambda: of_depth(1e6, None, PLANE)),
    Case("a near plane of 1e-4", "the wall's depth", lambda: of_depth(DEPTH, 1e-4, 0.1)),
    Case("a far plane at 1e6", "the wall's depth", lambda: of_depth(DEPTH, 1e6, 0.1)),
    Case("two halves of a scene back to back", "neither harms the other", turned_about),
)
