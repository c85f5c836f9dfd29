"""Cameras before a textured wall, whose depth is known."""

import numpy as np

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints


def textured_wall(frames=8, size=(48, 36), depth=4.0, step=0.25, seed=0):
    """Cameras in a row before a textured wall at a known depth."""
    rng = np.random.default_rng(seed)
    texture = np.kron(rng.random((60, 80, 3)), np.ones((4, 4, 1)))
    width, height = size
    focal = 40.0
    images = np.empty((frames, height, width, 3), np.uint8)
    poses = np.tile(np.eye(3, 4), (frames, 1, 1))
    for i in range(frames):
        center = (i - frames / 2) * step
        poses[i, 0, 3] = -center
        x = (np.arange(width) + 0.5 - width / 2) / focal * depth + center
        y = (np.arange(height) + 0.5 - height / 2) / focal * depth
        u = np.clip((x * 24 + 160).astype(int), 0, 319)
        v = np.clip((y * 24 + 120).astype(int), 0, 239)
        images[i] = texture[v[:, None], u[None]] * 255
    return Capture(
        names=tuple(f"{i}" for i in range(frames)),
        world_to_camera=poses,
        intrinsics=np.tile([focal, focal, width / 2, height / 2], (frames, 1)),
        images=images,
        sequences=("a",) * frames,
        points=SparsePoints(
            np.array([[0.0, 0.0, depth * 0.6], [0.0, 0.0, depth]]).repeat(10, axis=0),
            np.zeros((20, 3), np.uint8),
            np.tile(np.arange(20), frames),
            np.repeat(np.arange(frames), 20),
        ),
    )
