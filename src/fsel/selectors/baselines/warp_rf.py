"""WarpRF: the view that the picks' renderings, warped into it, explain least (2506.22433)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.compiled import exact
from fsel.core.geometry import pixel_rays
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.splat_views import greedily, reconstructed


class Inconsistency:
    """Criterion: at each pixel the least difference from the warped renderings, summed."""

    def __init__(self, capture: Capture, pool: np.ndarray, rows: np.ndarray) -> None:
        model, views = reconstructed(capture, pool, rows)
        self.images, self.cameras = model.render(views), views.intrinsics
        self.poses = model.frame.local_poses(views.world_to_camera)
        self.points = np.empty(self.images.shape)  # that the pixels show
        for at, (pose, k) in enumerate(zip(self.poses, self.cameras, strict=True)):
            depth = np.maximum(pose[2, :3] @ model.splats[:3] + pose[2, 3], 0)
            most = depth.max(initial=1e-9)
            shade = np.repeat(depth[:, None] / most * 255, 3, axis=1).astype(np.float32)
            shown = replace(model, colors=shade).render(views.subset(slice(at, at + 1)))[0] * most
            self.points[at] = (pixel_rays(k, *views.size) * shown - pose[:, 3]) @ pose[:, :3]
        self.least = np.full(self.images.shape[:3], np.inf)

    def scores(self) -> np.ndarray:
        return self.least.sum(axis=(1, 2))

    def add(self, row: int) -> None:
        _warp(self.images, self.points, self.poses[row], self.cameras[row], row, self.least)


@exact
def _warp(images, points, pose, k, row, least):
    """Lower `least` to the difference from view `row`, sampled bilinearly, at its border beyond."""
    views, height, width, _ = images.shape
    for view in range(views):
        for y in range(height):
            for x in range(width):
                seen = pose[:, 3].copy()
                for a in range(3):
                    for b in range(3):
                        seen[a] += pose[a, b] * points[view, y, x, b]
                depth = max(seen[2], 1e-9)
                u = min(max(k[0] * seen[0] / depth + k[2] - 0.5, 0.0), width - 1.0)
                v = min(max(k[1] * seen[1] / depth + k[3] - 0.5, 0.0), height - 1.0)
                left, top = min(int(u), width - 2), min(int(v), height - 2)
                across, down, total = u - left, v - top, 0.0
                for c in range(3):
                    above = images[row, top, left : left + 2, c]
                    below = images[row, top + 1, left : left + 2, c]
                    value = (1 - down) * ((1 - across) * above[0] + across * above[1])
                    value += down * ((1 - across) * below[0] + across * below[1])
                    total += abs(value - images[view, y, x, c])
                least[view, y, x] = min(least[view, y, x], total)


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick by `greedily`; a pick that was not reconstructed from is warped by its rendering."""
    return greedily(problem, k, Inconsistency)


METHOD = Method(
    "warp_rf", "WarpRF", "observed", nested=True, select=select, tracks=True, begins=True
)
