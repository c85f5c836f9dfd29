"""The scorer's inputs, one number at a time: the slow twin of the greedy loops."""

from dataclasses import replace

import numpy as np
from selection_problems import random_weights

from fsel.features.columns import APPEARANCE, FEATURES, INPUTS, NAMES, STATIC, TARGET_GAIN
from fsel.features.static import static_features
from fsel.selectors.policies import POLICIES as SHIPPED
from fsel.selectors.policies import Policy
from fsel.selectors.scorer import WIDTH, Linear, Network

POLICIES = {
    "less_is_more": SHIPPED["less_is_more"],
    "no_appearance": SHIPPED["less_is_more_no_appearance"],
    "every": Policy("every", "every", "observed", "targets", NAMES, Network, points=True),
    "fsel": SHIPPED["fsel"],
    "fsel_rule": SHIPPED["fsel_rule"],
    "sum": Policy("sum", "sum", "candidates", "proxies", FEATURES, Linear),
}
POLICIES["every_linear"] = replace(POLICIES["every"], name="every_linear", kind=Linear)


def random_scorer(policy, seed, gain=1.0):
    """A network in the range of a fresh one, or a linear rule of all that the policy reads."""
    if policy.kind is Network:
        return Network(random_weights(seed, gain))
    values = gain * np.random.default_rng([9, seed]).normal(size=len(policy.inputs))
    return Linear(dict(zip(policy.inputs, values.tolist(), strict=True)))


def spelled(coefficients):
    """The network whose score is a linear rule's: GELU(z) - GELU(-z) = z, so a pair of hidden units
    passes a value through. Layer one holds such a pair an input, layer two one for the sum."""
    values = np.array([coefficients.get(name, 0.0) for name in NAMES])
    first = np.zeros((WIDTH, INPUTS), np.float32)
    first[np.arange(INPUTS), np.arange(INPUTS)] = 1
    first[INPUTS + np.arange(INPUTS), np.arange(INPUTS)] = -1
    second = np.zeros((WIDTH, WIDTH), np.float32)
    second[0, :INPUTS] = second[1, INPUTS : 2 * INPUTS] = values
    second[0, INPUTS : 2 * INPUTS] = second[1, :INPUTS] = -values
    third = np.zeros((1, WIDTH), np.float32)
    third[0, :2] = (1, -1)
    weights = {"layer1.weight": first, "layer1.bias": np.zeros(WIDTH, np.float32)}
    weights |= {"layer2.weight": second, "layer2.bias": np.zeros(WIDTH, np.float32)}
    return Network(weights | {"layer3.weight": third, "layer3.bias": np.zeros(1, np.float32)})


def views_of(problem, reference):
    proxies = problem.capture.view(problem.proxies)
    return problem.targets if reference == "targets" else proxies


def z_scores(values):
    if values.std() <= 1e-9 * np.abs(values).max():
        return np.zeros(len(values))
    return (values - values.mean()) / values.std()


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def slow_inputs(problem, picked, policy):
    """(rows left, 19) the scorer's inputs after some picks, one number at a time."""
    frames = problem.pool(policy.pool)
    views = views_of(problem, policy.reference)
    appearance = any(name in policy.inputs for name in APPEARANCE)
    target_gain = TARGET_GAIN in policy.inputs
    static = static_features(problem, frames, views, appearance)
    columns = dict(zip(STATIC, static.T, strict=True))
    left = [row for row in range(len(frames)) if row not in picked]
    inputs = np.zeros((len(left), INPUTS))
    for position, name in enumerate(FEATURES):
        if name in columns:
            inputs[:, position] = z_scores(columns[name])[left]
    if picked:
        relations = slow_relations(problem, frames, views, left, picked, target_gain)
        for name, values in relations.items():
            if appearance or name != "rho_max_s":
                inputs[:, FEATURES.index(name)] = z_scores(np.array(values))
    if target_gain:
        inputs[:, 18] = slow_target_gain(problem, frames, views, left, picked)
    if target_gain and policy.points:
        inputs[:, 18] += 5 * slow_visibility_gain(problem, frames, views, left, picked)
    return np.array(left), inputs


def slow_spread(distances):
    """(rows left,) from (rows left, picks): to the fourth nearest of fewer than ten picks, the
    farthest of fewer than four; else as if all inverse squares came from one; to 1.5 means."""
    values = []
    for row in distances:
        if len(row) < 10:
            values.append(sorted(row)[: min(4, len(row))][-1])
        else:
            values.append(0.0 if min(row) == 0 else sum(d**-2 for d in row) ** -0.5)
    return np.minimum(values, 1.5 * np.mean(values))


def slow_relations(problem, frames, views, left, picked, target_gain):
    capture = problem.capture
    centroid = capture.centers[problem.candidates].mean(axis=0)
    points = [
        c + max(0.0, (centroid - c) @ a) * a for c, a in zip(views.centers, views.axes, strict=True)
    ]
    common = np.mean(points, axis=0)

    def over(measure, values, best):
        rows = [[measure(values[frames[i]], values[frames[j]]) for j in picked] for i in left]
        return [best(row) for row in rows] if best else slow_spread(rows)

    def apart(a, b):
        return np.linalg.norm(a - b)

    bearings = capture.centers - common
    bearings /= np.linalg.norm(bearings, axis=1, keepdims=True)
    turn, nearest = (apart, None) if target_gain else (angle, min)
    return {
        "d_min_s": over(apart, capture.centers, nearest),
        "gamma_min_s": over(turn, capture.axes, nearest),
        "rho_max_s": over(np.dot, problem.descriptors.astype(float), max),
        "phi_nov": over(turn, bearings, nearest),
    }


def slow_depths(problem, frames, views):
    """(T,) depths of the views, those known or that of the cameras' spread, and the scene's."""
    if problem.target_depths is not None:
        return problem.target_depths, np.median(problem.target_depths)
    centers = problem.capture.centers[frames]
    depth = 1.8 * np.sqrt(np.mean(np.linalg.norm(centers - centers.mean(axis=0), axis=1) ** 2))
    return [depth] * len(views), depth


def slow_target_gain(problem, frames, views, left, picked):
    """What each row would add to the mean over views of log(1 + summed closeness), to first order,
    in proportion less within 0.2 of a pick's look; less its remoteness."""
    centers, axes = problem.capture.centers[frames], problem.capture.axes[frames]
    depths, scene = slow_depths(problem, frames, views)
    closeness, far = np.zeros((2, len(frames), len(views)))
    for t, (c, a, depth) in enumerate(zip(views.centers, views.axes, depths, strict=True)):
        shift = np.linalg.norm(centers - c, axis=1)
        ahead = np.linalg.norm(centers + depth * axes - c - depth * a, axis=1)
        distance = (shift + 2 * ahead) / depth
        far[:, t] = distance
        for i in range(len(frames)):
            rank = np.sum(distance < distance[i])
            closeness[i, t] = 0.7**rank if rank < 64 else 0
    covered = closeness[list(picked)].sum(axis=0)
    remote = [min(far[i]) / 75 for i in left]
    looked = centers + scene * axes

    def apart(i, j):
        ahead = np.linalg.norm(looked[i] - looked[j])
        return (np.linalg.norm(centers[i] - centers[j]) + 2 * ahead) / scene

    novel = [min([1, *(apart(i, j) / 0.2 for j in picked)]) for i in left]
    gain = [(closeness[i] / (1 + covered)).mean() for i in left]
    return np.array(gain) * novel - remote


def slow_visibility_gain(problem, frames, views, left, picked):
    """What each row would add to the mean over points of P(N >= 1) + P(N >= 2), to first order, the
    mean of N's Poisson law being what the picks see of a point; where depths are known, two thirds
    of what it would add to the mean of the best sight that a pick has, and 0.7 of the second."""
    if (found := SEEN.get(id(problem))) is None or found[0] is not problem:
        found = SEEN[id(problem)] = problem, slow_visibility(problem, frames, views)
    seen = found[1]
    if problem.target_depths is not None:
        now = slow_worth(seen[list(picked)])
        return np.array([slow_worth(seen[[*picked, row]]) - now for row in left])
    rate = seen[list(picked)].sum(axis=0)
    return (seen * (1 + rate) * np.exp(-rate)).mean(axis=1)[left]


def slow_worth(seen):
    """Of (k, points) sights."""
    second, first = np.sort([*np.zeros((2, seen.shape[1])), *seen], axis=0)[-2:]
    return 2 / 3 * np.mean(first + 0.7 * second)


SEEN = {}  # id of a problem -> it, and what its rows see: slow enough to be computed once


def slow_visibility(problem, frames, views):
    """(n, points of all views) how much each row sees of each."""
    width, height = views.size
    columns = []
    fade = 40 if problem.target_depths is None else 20
    depths, _ = slow_depths(problem, frames, views)
    posed = zip(views.world_to_camera, views.intrinsics, views.centers, depths, strict=True)
    for pose, (fx, fy, cx, cy), center, depth in posed:
        for z in depth * np.array([0.5, 1, 2, 4]):
            for across, down in np.ndindex(6, 5):
                x, y = (across + 0.5) * width / 6, (down + 0.5) * height / 5
                local = z * np.array([(x - cx) / fx, (y - cy) / fy, 1])
                point = pose[:, :3].T @ (local - pose[:, 3])
                columns.append(
                    [slow_sight(problem.capture, i, point, center, fade) for i in frames]
                )
    return np.array(columns).T


def slow_sight(capture, frame, point, center, fade=40):
    """How much a frame sees of a point on a ray from a view's centre; 1/e at `fade` degrees."""
    pose, (fx, fy, cx, cy) = capture.world_to_camera[frame], capture.intrinsics[frame]
    x, y, z = pose[:, :3] @ point + pose[:, 3]
    if z <= 0 or not (0 <= x / z * fx + cx < capture.size[0]):
        return 0.0
    if not (0 <= y / z * fy + cy < capture.size[1]):
        return 0.0
    return np.exp(-angle(capture.centers[frame] - point, center - point) / np.radians(fade))
