"""Hard cameras and hard columns, on which a selection could fail."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from statistics import fmean
from typing import Any

import numpy as np

from fsel.core.problem import Problem
from fsel.evaluation.measuring import Run, picks_at, rng_by_name
from fsel.evaluation.methods import METHODS
from fsel.experiments.studies.hard_cases import Case, CaseOutcome, finite, quality, worlds
from fsel.features.columns import STATIC
from fsel.features.static import static_features
from fsel.selectors import pretrained, reference_loop
from fsel.selectors.greedy import greedy, standardise
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import Network, Scorer

K = 8
LENGTHS = [STATIC.index(name) for name in ("d_min_o", "d_mean_o", "d_p25_o", "b_perp", "b_par")]


def compare_picks(problem: Problem, reference: Problem, k: int) -> tuple[int, int, float]:
    """Return equal picks of the compiled loop and of the plain float64 loop on the reference, all
    picks, and the largest difference of their scores, relative."""
    same, total, error = 0, 0, 0.0
    network, rule = Network(worlds.random_weights(0)), pretrained.method().scorer
    scorers: dict[str, Scorer] = {"less_is_more": network, "fsel": rule}
    for name, scorer in scorers.items():
        prepared = POLICIES[name].prepare(problem)
        *arrays, visible, _ = prepared.rows  # the last is a number, which may be infinite
        finite(prepared.static, *arrays, visible.seen)
        rows, got = greedy(prepared, scorer, k)
        wanted, want = reference_loop.greedy(POLICIES[name].prepare(reference), scorer, k)
        finite(got, want)
        same += int((rows == wanted).sum())
        total += k
        error = max(error, float(np.abs(got - want).max() / (1 + np.abs(want).max())))
    return same, total, error


def run(
    make: Callable[[], Problem],
    make_reference: Callable[[], Problem] | None = None,
    exact: Callable[[Problem], float] | None = None,
    allowed: float = 1e-9,
) -> CaseOutcome:
    """Every method, the learned ones against the reference, and a reconstruction."""
    problem, reference = make(), make_reference() if make_reference else None
    for method in METHODS.values():
        every = len(problem.pool(method.pool))
        list(picks_at(problem, Run(method, 0), (K, every), rng_by_name(0)))
    same, total, error = compare_picks(problem, reference or problem, K)
    psnr = quality(problem.capture, problem.candidates[:K], problem.proxies)
    observed = f"{same} of {total} picks; {len(METHODS)} methods return; PSNR {psnr:.2f}"
    change = 0.0
    if reference is not None:
        change = psnr - quality(reference.capture, reference.candidates[:K], reference.proxies)
        observed += f", {change:+.3f} dB from the reference"
    if same < total or abs(change) > 0.02:
        error = np.inf
    lost = -change if reference is not None else np.nan
    return CaseOutcome(observed, max(error, exact(problem) if exact else 0.0), allowed, lost)


def case(name: str, expected: str, make: Callable[[], Problem], **how: Any) -> Case:
    """A case of `run` with its keywords."""
    return Case(name, expected, partial(run, make, **how))


def raw(problem: Problem) -> np.ndarray:
    """(n, 14) static features of the candidates."""
    views = problem.capture.view(problem.proxies)
    return static_features(problem, problem.candidates, views)


def z_scores(columns: list[int], problem: Problem) -> float:
    """Largest z-score of columns that are constant."""
    return float(np.abs(standardise(raw(problem)[:, columns])).max())


def exact_distances(problem: Problem) -> float:
    """Relative error of d_mean_o against correctly rounded distances of the exact centres."""
    centers, _ = worlds.cloud()
    if np.ptp(problem.capture.centers, axis=0).max() > 1e5:
        centers[::2] += [1e6, 0, 0]
    proxies = centers[problem.proxies]
    wanted = [
        fmean(math.dist(own, other) for other in proxies) for own in centers[problem.candidates]
    ]
    got = raw(problem)[:, STATIC.index("d_mean_o")]
    return float(np.abs(got / wanted - 1).max())


def exact_angles(problem: Problem) -> float:
    """Radians between the extremes of gamma_min_o and the only angles there are, 0 and pi."""
    gamma = raw(problem)[:, STATIC.index("gamma_min_o")]
    return float(np.minimum(gamma, np.pi - gamma).max())


def exact_z_scores(problem: Problem) -> float:
    """Error of the sharpness column's z-scores against sums without rounding."""
    column = raw(problem)[:, -1]
    mean = fmean(column)
    deviation = math.sqrt(math.fsum((v - mean) ** 2 for v in column) / len(column))
    wanted = np.array([(v - mean) / deviation for v in column])
    return float(np.abs(standardise(column[:, None])[:, 0] - wanted).max())


def zero_distance(problem: Problem) -> float:
    return float(raw(problem)[3, STATIC.index("d_min_o")])


def loud() -> CaseOutcome:
    problem = worlds.world()
    prepared = POLICIES["less_is_more"].prepare(problem)
    network = Network(worlds.random_weights(1, 60.0))
    rows, got = greedy(prepared, network, K)
    wanted, want = reference_loop.greedy(prepared, network, K)
    finite(got, want)
    same = int((rows == wanted).sum())
    error = float(np.abs(got / want - 1).max()) if same == K else np.inf
    return CaseOutcome(f"{same} of {K} picks; scores to {np.abs(want).max():.2g}", error, 1e-9)


SAME = "the picks of the plain float64 loop"
CASES = (
    case(
        "all cameras at one point",
        f"{SAME}; no column of lengths",
        worlds.one_point,
        exact=partial(z_scores, LENGTHS),
    ),
    case("all cameras on a line", SAME, worlds.line),
    case(
        "two clusters 1e6 apart", f"{SAME}; exact distances", worlds.clusters, exact=exact_distances
    ),
    case(
        "UTM: coordinates of 1e7, baselines of millimetres",
        "the picks and views of the same cameras near the origin",
        lambda: worlds.displaced(worlds.UTM, 1e-3),
        make_reference=worlds.world,
        allowed=1e-4,
    ),
    case(
        "coordinates of 1e7, baselines of a unit",
        "the same; exact distances",
        lambda: worlds.displaced(worlds.UTM, 1.0),
        make_reference=worlds.world,
        exact=exact_distances,
        allowed=1e-7,
    ),
    case(
        "exactly parallel axes", f"{SAME}; angles 0", lambda: worlds.parallel(1), exact=exact_angles
    ),
    case(
        "exactly opposite axes",
        f"{SAME}; angles 0 or pi",
        lambda: worlds.parallel(-1),
        exact=exact_angles,
    ),
    case(
        "a proxy that coincides with a candidate",
        f"{SAME}; distance 0",
        worlds.proxy_on_candidate,
        exact=zero_distance,
    ),
    case("one proxy", SAME, lambda: worlds.world(targets=1)),
    case(
        "a constant feature column",
        f"{SAME}; z-scores 0",
        worlds.equally_sharp,
        exact=partial(z_scores, [-1]),
    ),
    case(
        "a column with one outlier of 1e12",
        f"{SAME}; z-scores of exact sums",
        worlds.one_sharp,
        exact=exact_z_scores,
    ),
    Case("logits of 1e4, selection", SAME, loud),
)
