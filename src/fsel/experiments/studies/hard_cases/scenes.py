"""Scenes with awkward depths, reconstructed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import pixel_rays
from fsel.core.points import SparsePoints
from fsel.experiments.studies.hard_cases import worlds
from fsel.experiments.studies.hard_cases.case import Case, Finding, finite, quality
from fsel.reconstruct.splats import Splats

DEPTH = 4.0
SHARE = 20  # one point in so many lies at the odd depth
# of the wall's depth: the gap between two depth planes there. The last bits of the matching costs
# decide between neighbouring planes, and they differ between processors: the median error is
# 0.017 where vectors hold eight float32, 0.022 where they hold sixteen
PLANE = 0.027


def wall(depth: float, odd: float | None = None) -> Capture:
    """Twelve cameras abreast before a painted plane, with points on it and, if asked, elsewhere.

    Args:
        depth: of the plane, world units; baselines and paint are in proportion.
        odd: depth of a twentieth of the points.
    """
    n, count = 12, 200
    place = np.zeros((n, 3))
    place[:, 0] = (np.arange(n) - n / 2) * 0.25 * depth / DEPTH
    camera = np.array([40.0, 40.0, 24.0, 18.0])
    seen = pixel_rays(camera, 48, 36) + place[:, None, None] / depth
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(-1, 1, (count, 2)) * depth / 3, np.full(count, depth)])
    if odd is not None:
        xyz[::SHARE] *= odd / depth
    return Capture(
        names=tuple(f"{i:02d}" for i in range(n)),
        world_to_camera=worlds.poses(place, np.tile([0.0, 0.0, 1.0], (n, 1))),
        intrinsics=np.tile(camera, (n, 1)),
        images=worlds.paint(seen),
        sequences=("a",) * n,
        points=SparsePoints(
            xyz,
            np.zeros((count, 3), np.uint8),
            np.tile(np.arange(count), n),
            np.repeat(np.arange(n), count),
        ),
    )


def measure_quality(capture: Capture) -> tuple[float, float]:
    """PSNR in dB of every fourth frame from the others, and the splats' median depth error,
    relative, the plane being at the farthest of the most common depths."""
    held = np.arange(1, len(capture), 4)
    frames = np.setdiff1d(np.arange(len(capture)), held)
    position = Splats(capture).fit(frames).positions
    finite(position)
    assert capture.points is not None  # `wall` gives them
    depth = np.median(capture.points.xyz[:, 2])
    return quality(capture, frames, held), float(np.median(np.abs(position[:, 2] / depth - 1)))


def of_depth(depth: float, odd: float | None, allowed: float) -> Finding:
    """Depth error of the wall; PSNR against the same wall with all points on it."""
    usual, _ = measure_quality(wall(DEPTH))
    psnr, error = measure_quality(wall(depth, odd))
    return Finding(f"PSNR {psnr:.2f} dB, plain wall {usual:.2f}", error, allowed)


def turned_about() -> Finding:
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
        images=np.concatenate([first.images, first.images]),
        sequences=first.sequences * 2,
        points=None,
    )
    half = np.array([2, 3, 4, 6, 7])
    several = (half, np.append(half, half + 12))
    alone, together = (quality(both, frames, np.array([5])) for frames in several)
    told = f"PSNR {alone:.2f} dB, with the other side's frames {together:.2f}"
    return Finding(told, float(abs(together - alone)), 0.01)


CASES = (
    Case("a scene with one depth", "that depth", lambda: of_depth(DEPTH, None, PLANE)),
    Case("a scene at depth 1e-4", "that depth", lambda: of_depth(1e-4, None, PLANE)),
    Case("a scene at depth 1e6", "that depth", lambda: of_depth(1e6, None, PLANE)),
    Case("a near plane of 1e-4", "the wall's depth", lambda: of_depth(DEPTH, 1e-4, 0.1)),
    Case("a far plane at 1e6", "the wall's depth", lambda: of_depth(DEPTH, 1e6, 0.1)),
    Case("two halves of a scene back to back", "neither harms the other", turned_about),
)
