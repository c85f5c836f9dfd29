"""Filmed problems: cameras inside a painted ball, ordinary ones and hard in one way each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.captures.images.previews import sharpness
from fsel.core.capture import Capture, Views
from fsel.core.geometry import directions, pixel_rays, pose_matrices, poses_at
from fsel.core.problem import Problem
from fsel.core.split import evaluation_split
from fsel.features.appearance import descriptors
from fsel.selectors.scorer import SHAPES

FRAMES, TARGETS = 40, 5
WIDTH, HEIGHT = 32, 24
WALL = 3.0  # radius of the ball, in that of the cameras
UTM = np.array([5e5, 1e7, 120.0])  # easting, northing, height in metres


def rotations(ahead: np.ndarray) -> np.ndarray:
    """(n, 3, 3) world-to-camera rotations of cameras that look along (n, 3) unit vectors."""
    steep = np.abs(ahead[:, 1:2]) > 0.9
    down = np.where(steep, [1.0, 0, 0], [0.0, 1, 0])
    right = directions(np.cross(down, ahead), np.zeros(3))
    return np.stack([right, np.cross(ahead, right), ahead], axis=1)


def poses(centers: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """(n, 3, 4) world-to-camera of (n, 3) centres and optical axes."""
    return poses_at(centers, rotations(ahead))


def filmed(centers: np.ndarray, ahead: np.ndarray, zoom: np.ndarray | float = 1.0) -> Capture:
    """A capture of the painted ball around (n, 3) centres, looking along (n, 3) unit vectors."""
    n = len(centers)
    offset = centers - centers.mean(axis=0)
    radius = np.linalg.norm(offset, axis=1).max()
    cameras = np.tile([WIDTH * 0.7, WIDTH * 0.7, WIDTH / 2, HEIGHT / 2], (n, 1))
    cameras[:, :2] *= np.reshape(zoom, (-1, 1))
    rays = np.stack([pixel_rays(camera, WIDTH, HEIGHT) for camera in cameras])
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    world = np.einsum("nhwi,nij->nhwj", rays, rotations(ahead))
    # in units of the ball: |o + s d| = 1 has one positive root inside
    start = offset[:, None, None] / (WALL * radius if radius > 0 else 1.0)
    along = np.einsum("nhwj,nabj->nhw", world, start)
    reach = np.sqrt(along**2 + 1 - np.square(start).sum(axis=-1)) - along
    return Capture(
        names=tuple(f"{i:04d}" for i in range(n)),
        world_to_camera=poses(centers, ahead),
        intrinsics=cameras,
        images=paint(start + reach[..., None] * world),
        sequences=("a",) * n,
        source="a hard case",
    )


def paint(points: np.ndarray) -> np.ndarray:
    """(..., 3) uint8 colours of (..., 3) points, from waves about half a unit long."""
    rng = np.random.default_rng(3)
    waves = rng.normal(scale=12, size=(3, 3, 6))
    phase = rng.uniform(0, 2 * np.pi, (3, 6))
    value = np.sin(np.einsum("...i,icw->...cw", points, waves) + phase).mean(axis=-1)
    return np.clip(128 + 200 * value, 0, 255).astype(np.uint8)


def problem_on(capture: Capture, targets: int = TARGETS, draw: int = 0) -> Problem:
    """The problem of one draw of targets, with measured descriptors and sharpness."""
    split = evaluation_split(capture, draw, 0, targets)
    return Problem(
        capture=capture,
        candidates=split.candidates,
        proxies=split.proxies,
        targets=capture.view(split.targets),
        descriptors=descriptors(capture.images, "lab_hog"),
        sharpness=sharpness(capture.images),
    )


def cloud(n: int = FRAMES) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) centres and (n, 3) axes at random; centres are multiples of 2^-10, and so stay exact
    when 10^7 is added to them."""
    rng = np.random.default_rng(0)
    ahead = rng.normal(size=(n, 3))
    centers = np.round(rng.normal(size=(n, 3)) * 1024) / 1024
    return centers, ahead / np.linalg.norm(ahead, axis=1, keepdims=True)


def world(n: int = FRAMES, targets: int = TARGETS) -> Problem:
    """The ordinary problem that the hard ones are variations of."""
    return problem_on(filmed(*cloud(n)), targets)


def moved(problem: Problem, rotation: np.ndarray, shift: np.ndarray, scale: float) -> Problem:
    """The same problem in the world scale * rotation @ x + shift."""

    def pose(world_to_camera: np.ndarray) -> np.ndarray:
        turned = world_to_camera[:, :, :3] @ rotation.T
        offset = scale * world_to_camera[:, :, 3] - turned @ shift
        return pose_matrices(turned, offset)

    capture, targets = problem.capture, problem.targets
    points = capture.points
    if points is not None:
        points = replace(points, xyz=scale * points.xyz @ rotation.T + shift)
    return replace(
        problem,
        capture=replace(capture, world_to_camera=pose(capture.world_to_camera), points=points),
        targets=Views(pose(targets.world_to_camera), targets.intrinsics, targets.size),
    )


def random_weights(seed: int, gain: float = 1.0) -> dict[str, np.ndarray]:
    """Scorer weights in the range of a fresh network, times `gain`."""
    rng = np.random.default_rng([8, seed])
    return {
        name: (rng.uniform(-gain, gain, shape) / np.sqrt(shape[-1])).astype(np.float32)
        for name, shape in SHAPES.items()
    }


def at(centers: np.ndarray, ahead: np.ndarray | None = None) -> Problem:
    """The problem of given centres, axes at random unless given."""
    axes = cloud(len(centers))[1] if ahead is None else ahead
    return problem_on(filmed(centers, axes))


def one_point() -> Problem:
    return at(np.tile([0.3, 1.7, -2.1], (FRAMES, 1)))


def line() -> Problem:
    return at(np.linspace(0, 1, FRAMES)[:, None] * [1.0, 2.0, -0.5])


def clusters() -> Problem:
    centers, ahead = cloud()
    centers[::2] += [1e6, 0, 0]
    return at(centers, ahead)


def displaced(shift: np.ndarray, scale: float) -> Problem:
    return moved(world(), np.eye(3), shift, scale)


def parallel(sign: float) -> Problem:
    """Axes along one line to the last bit, in alternating sense for a sign of -1."""
    centers, noise = cloud()
    axis = np.array([0.48, 0.6, 0.64])
    sense = np.where(np.arange(len(centers)) % 2, sign, 1.0)[:, None]
    return at(centers, axis * sense + 2e-16 * noise)


def proxy_on_candidate() -> Problem:
    problem = world()
    pose = problem.capture.world_to_camera.copy()
    pose[problem.candidates[3]] = pose[problem.proxies[0]]
    return replace(problem, capture=replace(problem.capture, world_to_camera=pose))


def equally_sharp() -> Problem:
    problem = world()
    return replace(problem, sharpness=np.full_like(problem.sharpness, 0.1))


def one_sharp() -> Problem:
    problem = world()
    sharpness = problem.sharpness.copy()
    sharpness[problem.candidates[7]] = 1e12
    return replace(problem, sharpness=sharpness)
