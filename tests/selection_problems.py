"""Small posed captures and selection problems for the tests."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.core.capture import Capture, Views
from fsel.core.geometry import pose_matrices
from fsel.core.points import SparsePoints
from fsel.core.problem import Problem
from fsel.core.split import evaluation_split
from fsel.selectors.scorer import SHAPES


def capture_of(centers, rotations, sequences=None, size=(8, 6), seed=0):
    """A capture from camera centres (N, 3) and world-to-camera rotations (N, 3, 3)."""
    n = len(centers)
    shift = -np.einsum("nij,nj->ni", rotations, centers)
    rng = np.random.default_rng(seed)
    return Capture(
        names=tuple(f"frame_{i:04d}" for i in range(n)),
        world_to_camera=np.concatenate([rotations, shift[..., None]], axis=2),
        intrinsics=np.tile([size[0] * 0.8, size[0] * 0.8, size[0] / 2, size[1] / 2], (n, 1)),
        images=rng.integers(0, 255, (n, size[1], size[0], 3), dtype=np.uint8),
        sequences=sequences or ("a",) * n,
        source="a test",
    )


def in_line(places, **more):
    """A capture of cameras on the x axis that look along z."""
    centers = np.asarray(places, float)[:, None] * [1.0, 0, 0]
    return capture_of(centers, np.tile(np.eye(3), (len(centers), 1, 1)), **more)


def around(poses, size=(64, 48), **more):
    """A capture with the given world-to-camera poses."""
    rotations = poses[:, :, :3]
    centers = -np.einsum("nij,ni->nj", rotations, poses[:, :, 3])
    return capture_of(centers, rotations, size=size, **more)


def numbered(capture):
    """The same with the number of each frame in its top left pixel."""
    images = np.asarray(capture.images).copy()
    images[:, 0, 0, 0] = np.arange(len(capture))
    return replace(capture, images=images)


def pointed(capture):
    """The same of eight frames with four points in short tracks, and masks of three rows."""
    xyz = np.random.default_rng(0).uniform(-0.5, 0.5, (4, 3))
    seen = np.array([[0, 0, 1, 1, 2, 3, 3], [0, 3, 5, 1, 3, 5, 0]])  # points, frames
    points = SparsePoints(xyz, np.full((4, 3), 7, np.uint8), *seen)
    masks = np.zeros(capture.images.shape[:3], bool)
    masks[:, 2:5] = True
    return replace(capture, points=points, masks=masks)


def random_capture(n, seed=0):
    """Cameras in a cloud, turned at random."""
    rng = np.random.default_rng(seed)
    rotations = Rotation.random(n, rng=rng).as_matrix()
    return capture_of(rng.normal(size=(n, 3)), rotations, seed=seed)


def problem_on(capture, targets=4, seed=0, width=12):
    """A selection problem with random unit descriptors and sharpness."""
    rng = np.random.default_rng([7, seed])
    descriptors = rng.normal(size=(len(capture), width))
    descriptors /= np.linalg.norm(descriptors, axis=1, keepdims=True)
    split = evaluation_split(capture, 0, seed, targets=targets)
    seen = descriptors.astype(np.float32), rng.uniform(10, 900, len(capture))
    return problem_of(capture, split.proxies, split.candidates, split.targets, *seen)


def problem_of(capture, proxies, candidates, targets=(0, 1), descriptors=None, sharpness=None):
    """A selection problem of the frames stated, by default without anything to see."""
    n = len(capture)
    return Problem(
        capture=capture,
        candidates=np.array(candidates),
        proxies=np.array(proxies, np.int64),
        targets=capture.view(np.array(targets)),
        descriptors=np.zeros((n, 1), np.float32) if descriptors is None else descriptors,
        sharpness=np.zeros(n) if sharpness is None else np.array(sharpness, float),
    )


def random_problem(n=40, seed=0, targets=4):
    """`problem_on` a `random_capture`."""
    return problem_on(random_capture(n, seed), targets, seed)


def with_points(problem, count=60, seed=0):
    """The same problem with sparse points among the cameras, each seen by some of the frames."""
    rng = np.random.default_rng([9, seed])
    n = len(problem.capture)
    sees = rng.random((count, n)) < rng.uniform(0.1, 0.7, (count, 1))
    track_point, track_frame = np.nonzero(sees)
    points = SparsePoints(
        xyz=rng.normal(scale=2, size=(count, 3)) + problem.capture.centers.mean(axis=0),
        rgb=np.zeros((count, 3), np.uint8),
        track_point=track_point,
        track_frame=track_frame,
    )
    return replace(problem, capture=replace(problem.capture, points=points))


def with_points_ahead(problem, seed=0, count=5):
    """The same problem where each frame alone sees a few points along its axis."""
    rng, capture = np.random.default_rng([9, seed]), problem.capture
    rows = np.repeat(np.arange(len(capture)), count)
    depth = rng.uniform(0.5, 4, (len(rows), 1)) * np.linalg.norm(capture.centers, axis=1).mean()
    xyz = capture.centers[rows] + depth * capture.axes[rows]
    points = SparsePoints(xyz, np.zeros((len(rows), 3), np.uint8), np.arange(len(rows)), rows)
    return replace(problem, capture=replace(capture, points=points))


def permuted(problem, order):
    """The same problem with its frames in another order: frame i is the old frame order[i]."""
    place = np.argsort(order)
    return replace(
        problem,
        capture=problem.capture.subset(order),
        candidates=np.sort(place[problem.candidates]),
        proxies=place[problem.proxies],
        descriptors=problem.descriptors[order],
        sharpness=problem.sharpness[order],
    )


def moved(problem, rotation, shift, scale):
    """The same problem in the world scale * rotation @ x + shift."""

    def pose(world_to_camera):
        turned = world_to_camera[:, :, :3] @ rotation.T
        return pose_matrices(turned, scale * world_to_camera[:, :, 3] - turned @ shift)

    capture, targets = problem.capture, problem.targets
    points = capture.points
    if points is not None:
        points = replace(points, xyz=scale * points.xyz @ rotation.T + shift)
    return replace(
        problem,
        capture=replace(capture, world_to_camera=pose(capture.world_to_camera), points=points),
        targets=Views(pose(targets.world_to_camera), targets.intrinsics, targets.size),
    )


def random_weights(seed, gain=1.0):
    """Scorer weights in the range of a fresh network, times `gain`."""
    rng = np.random.default_rng([8, seed])
    return {
        name: (rng.uniform(-gain, gain, shape) / np.sqrt(shape[-1])).astype(np.float32)
        for name, shape in SHAPES.items()
    }
