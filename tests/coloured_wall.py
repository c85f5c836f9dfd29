"""Cameras before a smoothly coloured wall, and how well a model shows it."""

from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints
from fsel.metrics import score_views


def wall(frames=8, size=(40, 30), depth=4.0, step=0.25, seed=0):
    """Cameras in a row before a smoothly coloured wall, with points that neighbours see."""
    rng = np.random.default_rng(seed)
    waves, phases = rng.uniform(1, 5, (12, 2)), rng.uniform(0, 6, (12, 3))
    width, height, focal = *size, 36.0
    poses, images = np.tile(np.eye(3, 4), (frames, 1, 1)), []
    x = (np.arange(width) + 0.5 - width / 2) / focal * depth
    y = (np.arange(height) + 0.5 - height / 2) / focal * depth
    for i in range(frames):
        poses[i, 0, 3] = -(i - frames / 2) * step
        at = x[None, :] - poses[i, 0, 3], y[:, None]
        angles = waves[:, 0, None, None] * at[0] + waves[:, 1, None, None] * at[1]
        light = np.sin(angles[..., None] + phases[:, None, None]).sum(axis=0)
        images.append(np.clip(128 + 25 * light, 0, 255).astype(np.uint8))
    count = 30
    xyz = np.column_stack([rng.uniform(-2, 2, count), rng.uniform(-1, 1, count), [depth] * count])
    xyz[::2, 2] *= 0.6
    seen = np.arange(count)[:, None] % frames == np.arange(frames)
    seen |= np.roll(seen, 1, axis=1) | np.roll(seen, 2, axis=1)
    seen[:10] = True
    track = np.argwhere(seen)
    return Capture(
        names=tuple(f"{i}" for i in range(frames)),
        world_to_camera=poses,
        intrinsics=np.tile([focal, focal, width / 2, height / 2], (frames, 1)),
        images=np.array(images),
        sequences=("a",) * frames,
        points=SparsePoints(xyz, np.full((count, 3), 90, np.uint8), track[:, 0], track[:, 1]),
        source="wall",
    )


def psnr(model, capture, frames):
    rendered = model.render(capture.view(frames))
    return score_views(rendered, capture.images[frames])[:, 0].mean()


def in_another_world(capture, scale, shift):
    """The same capture with every length multiplied and the origin elsewhere."""
    rotation, translation = capture.world_to_camera[:, :, :3], capture.world_to_camera[:, :, 3]
    translation = scale * translation - rotation @ np.asarray(shift, float)
    return replace(
        capture,
        world_to_camera=np.concatenate([rotation, translation[:, :, None]], axis=2),
        points=replace(capture.points, xyz=scale * capture.points.xyz + shift),
    )
