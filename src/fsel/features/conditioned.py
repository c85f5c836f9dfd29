"""The target gain, and distances that count all picks: what `fsel` adds to the paper's features.

*Distances.* While picks are few, each needs others beside it to be matched with: the next group of
frames should be far, so the fourth nearest counts. Later all count, by the sum of their inverse
squared distances. A frame far from everything is no better than one far enough.

*Visibility.* A frame may be close to a view and see other things. Points are spread over each
view's image at four depths, since the true one is not known. A frame that has a point in its image
counts by how nearly it looks along the view's own ray. With the sum of what the picks count as the
mean of a Poisson law, a point is worth the chance that one or more see it plus the chance that two
or more do: a second frame lets the first be matched. Where the depth of each view is known, lengths
are in it, and a point is worth the best and a share of the second best sight that a pick has of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fsel.core.capture import Views
from fsel.core.geometry import centered, directions, pairwise_distances, viewing_angles

REACH = 1.8  # of the cameras' spread: how far ahead of a camera lies what it looks at
TURN = 2.0  # what a shift of the point looked at weighs beside a shift of the camera
FADE = 0.7  # closeness of a view's next frame, of the one before
EQUAL = 1e-9  # of a scene's depth: distances closer than this are one
LAST = 64  # ranks; closeness beyond is below 1e-9 and counts as nothing
NOVEL = 0.2  # look distance from every pick at which a frame adds all of its closeness
FAR = 75.0  # scene depths from every view that cost as much as the first frame of all views gains
POINTS = 5.0  # what points that come into view weigh beside closeness

SURROGATE_DECAY_START = 7.0
"""Picks after which the gain for views that stand for a whole capture counts less."""

FEW = 10  # with fewer picks, only the nearest of them count
GROUP = 4  # the pick that counts then, from the nearest on; the farthest where there are fewer
ENOUGH = 1.5  # of the mean over the frames still to be had: distances beyond count as this one

GRID = (6, 5)  # points across and down an image
DEPTHS = (0.5, 1.0, 2.0, 4.0)  # where they lie, over the depth of the scene
ANGLE = math.radians(40.0)  # at a point, from the view: there a frame counts 1/e of the view itself
ANGLE_OF_TWO = math.radians(20.0)  # the same where the best two sights of a point count
BEST, SECOND = 2 / 3, 7 / 15  # what they count
NEAREST = 256  # frames of a view whose sight is measured; the others are taken to see nothing


def look_distance(
    centers: np.ndarray, axes: np.ndarray, views: Views, depth: np.ndarray
) -> np.ndarray:
    """Return (n, T) distances of (n, 3) centres from T views plus twice those of the points looked
    at along (n, 3) unit axes, in the (T,) depths of the views, world units."""
    shift = pairwise_distances(centers, views.centers)
    looks = zip(depth, views.centers + depth[:, None] * views.axes, strict=True)
    ahead = [pairwise_distances(centers + far * axes, point[None]) for far, point in looks]
    return (shift + TURN * np.hstack(ahead)) / depth


def look_embedding(centers: np.ndarray, axes: np.ndarray, depth: float | None = None) -> np.ndarray:
    """Return (n, 6) where cameras are and, twice, what they look at, in depths of the scene, by
    default `look_depth`: the distances of first and of last three numbers add up to the look
    distance."""
    here = centered(centers) / (look_depth(centers) if depth is None else depth)
    return np.hstack([here, TURN * (here + axes)])


def look_depth(centers: np.ndarray) -> float:
    """Return how far ahead of cameras lies what they look at, world units; 1 for cameras in one
    place: 1.8 times the root mean square distance of their centres from the mean."""
    spread = np.sqrt(np.mean(np.sum(centered(centers) ** 2, axis=1)))
    return REACH * spread if spread > 0 else 1.0


def closeness(distance: np.ndarray) -> np.ndarray:
    """Return (n, T) 0.7 to the power of a frame's rank by its (n, T) look distance to a view;
    equally distant frames share the lower rank, also where rounding parts them."""
    columns = zip(np.sort(distance, axis=0).T, distance.T, strict=True)
    rank = np.stack([np.searchsorted(few, all_ - EQUAL) for few, all_ in columns], axis=1)
    return np.where(rank < LAST, FADE ** np.minimum(rank, LAST), 0.0)


def nearest_view_penalty(distance: np.ndarray) -> np.ndarray:
    """Return (n,) distance of each frame's closest view, in what a target gain is worth: frames far
    from all views are novel, and of no use."""
    return distance.min(axis=1) / FAR


class Visibility(NamedTuple):
    """Points of each of O views that frames see; O = 0 where they are not read.

    Attributes:
        nearest: (O, M) int64 the rows that are closest to each view.
        seen: (O, M, Q) how much each of them sees of each of the view's Q points, 0..1.
        two: whether the best two sights of a point count, not the sum of all.
    """

    nearest: np.ndarray
    seen: np.ndarray
    two: bool = False


NOTHING = Visibility(np.empty((0, 0), np.int64), np.empty((0, 0, 0)))


def visibility(
    frames: Views, views: Views, distance: np.ndarray, depth: np.ndarray, *, two: bool = False
) -> Visibility:
    """Measure what the nearest of n frames, by (n, O) `look_distance`, see of the points of O
    views at (O,) depths, world units; `two` as of `Visibility`."""
    angle = ANGLE_OF_TWO if two else ANGLE
    points = view_points(views, depth)
    nearest = np.argsort(distance, axis=0, kind="stable")[:NEAREST].T.copy()
    seen = np.zeros((*nearest.shape, points.shape[1]), distance.dtype)
    for view, rows in enumerate(nearest):  # arrays of all views would not fit the processor's cache
        inside = in_image(frames, rows, views.centers[view], points[view])
        place, point = np.nonzero(inside)
        here, there = frames.centers.take(rows[place], axis=0), points[view].take(point, axis=0)
        to_view = directions(views.centers[view], points[view]).take(point, axis=0)
        seen[view][inside] = np.exp(-viewing_angles(directions(here, there), to_view) / angle)
    return Visibility(nearest, seen, two)


def view_points(views: Views, depth: np.ndarray) -> np.ndarray:
    """Return (O, Q, 3) points that lie behind a grid over each of O views' images, at multiples of
    their (O,) depths."""
    across, down = (
        (np.arange(n) + 0.5) / n * side for n, side in zip(GRID, views.size, strict=True)
    )
    x, y, share = (a.ravel() for a in np.meshgrid(across, down, DEPTHS))
    fx, fy, cx, cy = views.intrinsics.T[:, :, None]
    z = depth[:, None] * share
    local = np.stack([(x - cx) / fx * z, (y - cy) / fy * z, z])
    turned = np.einsum("cop,ocd->opd", local, views.world_to_camera[:, :, :3])
    return views.centers[:, None] + turned


def in_image(frames: Views, rows: np.ndarray, center: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (M, Q) bool whether (Q, 3) points of a view at `center` lie in images of M frames."""
    turns = frames.world_to_camera[rows, :, :3]
    # from the view's centre, not the world's origin: coordinates may be large
    local = (turns.reshape(-1, 3) @ (points - center).T).reshape(len(rows), 3, -1)
    local += np.einsum("mcd,md->mc", turns, center - frames.centers[rows])[..., None]
    x, y, z = np.moveaxis(local, 1, 0)
    fx, fy, cx, cy = frames.intrinsics[rows].T[..., None]
    width, height = frames.size
    across = (x * fx >= -cx * z) & (x * fx < (width - cx) * z)
    return (z > 0) & across & (y * fy >= -cy * z) & (y * fy < (height - cy) * z)


def with_sight(sights: np.ndarray, visible: Visibility, row: int) -> np.ndarray:
    """Return (2, O, Q) sights that picks have of each point after one more pick: their sum and
    zero, or the best and the second best."""
    views, places = np.nonzero(visible.nearest == row)
    seen, (first, second), found = visible.seen[views, places], sights[:, views], sights.copy()
    if visible.two:
        found[:, views] = np.maximum(first, seen), np.maximum(second, np.minimum(first, seen))
    else:
        found[0, views] += seen
    return found


def visibility_gain(visible: Visibility, sights: np.ndarray, rows: int) -> np.ndarray:
    """Return (n,) value of one more of n rows to the views' points, their mean, after picks with
    (2, O, Q) sights of them: with sum r, P(N >= 1) + P(N >= 2) of a Poisson N has the slope (1 + r)
    exp(-r); of the best two, what they and their shares grow by."""
    first, second = sights
    if visible.two:
        worth = np.zeros(visible.nearest.shape)
        for view, seen in enumerate(visible.seen):  # as in `visibility`, for the cache
            for least, share in ((first[view], BEST - SECOND), (second[view], SECOND)):
                grown = np.maximum(seen, least) - least
                worth[view] += share / first.size * grown.sum(axis=1)
    else:
        slope = (1 + first) * np.exp(-first) / max(first.size, 1)
        # einsum sums every row alike; a matrix product may part equal rows in their last bit
        worth = np.einsum("omq,oq->om", visible.seen, slope)
    gain = np.bincount(visible.nearest.ravel(), worth.ravel(), rows)
    return gain.astype(visible.seen.dtype, copy=False)
