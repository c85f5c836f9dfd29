"""The scorer's inputs, one number at a time: the slow twin of the greedy loops."""

import numpy as np

from fsel.features.static import FEATURES, STATIC, static_features
from fsel.selector.scorer import INPUTS

POLICIES = {
    "ours": {
        "pool": "candidates", "reference": "proxies", "appearance": True, "coverage": False,
    },
    "no_appearance": {
        "pool": "candidates", "reference": "proxies", "appearance": False, "coverage": False,
    },
    "fsel": {"pool": "observed", "reference": "targets", "appearance": True, "coverage": True},
}  # fmt: skip


def views_of(problem, reference):
    proxies = problem.capture.view(problem.proxies)
    return problem.targets if reference == "targets" else proxies


def z_scores(values):
    if values.std() <= 1e-9 * np.abs(values).max():
        return np.zeros(len(values))
    return (values - values.mean()) / values.std()


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def slow_inputs(problem, picked, *, pool, reference, appearance, coverage):
    """(rows left, 19) the scorer's inputs after some picks, one number at a time."""
    frames = problem.pool(pool)
    views = views_of(problem, reference)
    static = static_features(problem, frames, views, appearance)
    columns = dict(zip(STATIC, static.T, strict=True))
    left = [row for row in range(len(frames)) if row not in picked]
    inputs = np.zeros((len(left), INPUTS))
    for position, name in enumerate(FEATURES):
        if name in columns:
            inputs[:, position] = z_scores(columns[name])[left]
    if picked:
        relations = slow_relations(problem, frames, views, left, picked, coverage)
        for name, values in relations.items():
            if appearance or name != "rho_max_s":
                inputs[:, FEATURES.index(name)] = z_scores(np.array(values))
    if coverage:
        inputs[:, 18] = slow_coverage(problem, frames, views, left, picked)
    return np.array(left), inputs


def slow_company(distances):
    """(rows left,) from (rows left, picks): to the fourth nearest of fewer than ten picks, the
    farthest of fewer than four; else as if all inverse squares came from one; to 1.5 means."""
    values = []
    for row in distances:
        if len(row) < 10:
            values.append(sorted(row)[: min(4, len(row))][-1])
        else:
            values.append(0.0 if min(row) == 0 else sum(d**-2 for d in row) ** -0.5)
    return np.minimum(values, 1.5 * np.mean(values))


def slow_relations(problem, frames, views, left, picked, coverage):
    capture = problem.capture
    centroid = capture.centers[problem.candidates].mean(axis=0)
    points = [
        c + max(0.0, (centroid - c) @ a) * a for c, a in zip(views.centers, views.axes, strict=True)
    ]
    common = np.mean(points, axis=0)

    def over(measure, best):
        return [best(measure(frames[i], frames[j]) for j in picked) for i in left]

    centers, axes, described = capture.centers, capture.axes, problem.descriptors.astype(float)
    if coverage:
        bearings = centers - common
        bearings /= np.linalg.norm(bearings, axis=1, keepdims=True)
        compared = {"d_min_s": centers, "gamma_min_s": axes, "phi_nov": bearings}
        company = {}
        for name, place in compared.items():
            at, picks = place[frames[left]], place[frames[picked]]
            company[name] = slow_company([[np.linalg.norm(p - j) for j in picks] for p in at])
        return company | {"rho_max_s": over(lambda i, j: described[i] @ described[j], max)}
    return {
        "d_min_s": over(lambda i, j: np.linalg.norm(centers[i] - centers[j]), min),
        "gamma_min_s": over(lambda i, j: angle(axes[i], axes[j]), min),
        "rho_max_s": over(lambda i, j: described[i] @ described[j], max),
        "phi_nov": over(lambda i, j: angle(centers[i] - common, centers[j] - common), min),
    }


def slow_coverage(problem, frames, views, left, picked):
    """What each row would add to the mean over views of log(1 + summed closeness), to first order,
    in proportion less within 0.2 of a pick's look; less its remoteness."""
    centers, axes = problem.capture.centers[frames], problem.capture.axes[frames]
    depth = 1.8 * np.sqrt(np.mean(np.linalg.norm(centers - centers.mean(axis=0), axis=1) ** 2))
    closeness, far = np.zeros((2, len(frames), len(views)))
    for t, (c, a) in enumerate(zip(views.centers, views.axes, strict=True)):
        shift = np.linalg.norm(centers - c, axis=1)
        ahead = np.linalg.norm(centers + depth * axes - c - depth * a, axis=1)
        distance = shift + 2 * ahead
        far[:, t] = distance
        for i in range(len(frames)):
            rank = np.sum(distance < distance[i])
            closeness[i, t] = 0.7**rank if rank < 64 else 0
    covered = closeness[list(picked)].sum(axis=0)
    remote = [min(far[i]) / depth / 75 for i in left]
    looked = centers + depth * axes

    def apart(i, j):
        ahead = np.linalg.norm(looked[i] - looked[j])
        return (np.linalg.norm(centers[i] - centers[j]) + 2 * ahead) / depth

    novel = [min([1, *(apart(i, j) / 0.2 for j in picked)]) for i in left]
    gain = [(closeness[i] / (1 + covered)).mean() for i in left]
    return np.array(gain) * novel - remote
