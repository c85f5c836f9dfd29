"""Splats that some requested view can see, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.capture import Views
from fsel.reconstruct.splats import SplatModel

MARGIN = 2.0  # pixels: the renderer's footprints and depth pass reach one beyond the image


def seen_by(model: SplatModel, views: Views) -> SplatModel:
    """The splats that fall into any of the views; it renders them exactly as the whole model does.

    Useful where a model is stored or sent for a known path; in a search, which renders every model
    once, the test would take the time that it saves.

    Args:
        model: a reconstruction.
        views: T views that will be rendered.
    """
    width, height = views.size
    kept = np.zeros(model.primitives, bool)
    poses = model.frame.local_poses(views.world_to_camera)
    for pose, (fx, fy, cx, cy) in zip(poses, views.intrinsics, strict=True):
        x, y, z = pose[:, :3] @ model.splats[:3] + pose[:, 3:]
        ahead = np.maximum(z, np.finfo(np.float32).tiny)
        u, v = fx * x / ahead + cx, fy * y / ahead + cy
        inside = (u > -MARGIN) & (u < width + MARGIN) & (v > -MARGIN) & (v < height + MARGIN)
        kept |= inside & (z > 0)
    splats = np.ascontiguousarray(model.splats[:, kept])
    return replace(model, splats=splats, colors=model.colors[kept])
