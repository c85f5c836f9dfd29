"""The greedy loop around the scorer (paper, section 3.3), without torch and without waste.

What does not change is computed once: the static features, their standardisation and their part
of the first layer. What follows the selection is a running minimum. Geometry is float64; the
network runs in float32, whose error (about 1e-6 of a score) decides only between near ties.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np

from fsel.capture import Views
from fsel.features import APPEARANCE, FEATURES, proxy_points, static_features
from fsel.geometry import directions, pose_distance
from fsel.problem import Method, Problem
from fsel.scorer import INPUTS, Scorer

FLAT = 1e-9  # a column whose deviation is below this share of its scale carries no information
RELATIONAL_INPUTS = np.arange(13)
CONDITIONED_INPUTS = np.arange(13, 17)
SHARPNESS_INPUT = 17
COVERAGE_INPUT = 18
DYNAMIC = np.append(CONDITIONED_INPUTS, COVERAGE_INPUT)
REACH_RANK = 4  # the coverage kernel of a view falls to 1/e at its fourth nearest frame

_jit = numba.njit(cache=True, nogil=True)


@dataclass(frozen=True)
class Prepared:
    """Everything that a greedy selection needs and that no pick changes.

    Attributes:
        pool: (n,) int64 frames, ascending; the rows of everything below.
        static: (n, 19) float64 standardised inputs, zero in the columns that follow the selection.
        centers: (n, 3) camera centres, relative to their mean.
        axes: (n, 3) unit optical axes.
        bearings: (n, 3) unit directions from the common reference point.
        descriptors: (n, D) float32; D = 0 when appearance is switched off.
        kernel: (n, O) float64 closeness of frame and view for the coverage input; O = 0 without.
    """

    pool: np.ndarray
    static: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    bearings: np.ndarray
    descriptors: np.ndarray
    kernel: np.ndarray


def prepare(
    problem: Problem, *, pool: str, reference: str, appearance: bool, coverage: bool
) -> Prepared:
    """Compute what no pick changes.

    Args:
        problem: the selection problem.
        pool: `candidates` (P) or `observed` (P and O).
        reference: `proxies`, as in the paper, or `targets`: whose poses stand for the request.
        appearance: whether the four appearance features are used.
        coverage: whether the nineteenth input, zero in the paper, carries the coverage gain.
    """
    frames = problem.pool(pool)
    references = reference_views(problem, reference)
    raw = static_features(problem, frames, references)
    static = np.zeros((len(frames), INPUTS))
    static[:, RELATIONAL_INPUTS] = standardise(raw[:, :13])
    static[:, SHARPNESS_INPUT] = standardise(raw[:, 13:])[:, 0]
    if not appearance:
        static[:, [FEATURES.index(name) for name in APPEARANCE]] = 0
    capture = problem.capture
    centers, axes = capture.centers[frames], capture.axes[frames]
    return Prepared(
        pool=frames,
        static=static,
        centers=centers - centers.mean(axis=0),
        axes=np.ascontiguousarray(axes),
        bearings=directions(centers, common_reference(problem, references)),
        descriptors=problem.descriptors[frames][:, : None if appearance else 0],
        kernel=coverage_kernel(centers, axes, references)[:, : None if coverage else 0],
    )


def reference_views(problem: Problem, reference: str) -> Views:
    """Poses that stand for the request: the proxies' or the targets' own."""
    if reference == "targets":
        return problem.targets
    return problem.capture.view(problem.proxies)


def common_reference(problem: Problem, references: Views) -> np.ndarray:
    """(3,) mean of the views' reference points, from which angular novelty is measured."""
    return proxy_points(problem, references).mean(axis=0)


def coverage_kernel(centers: np.ndarray, axes: np.ndarray, references: Views) -> np.ndarray:
    """(n, O) closeness exp(-d / h) of frames and views, d being the split's distance.

    h, one a view, is the distance of its fourth nearest frame: the kernel follows the density of
    the capture around each view.
    """
    distance = pose_distance(centers, axes, references.centers, references.axes)
    rank = min(REACH_RANK, len(centers)) - 1
    reach = np.partition(distance, rank, axis=0)[rank]
    return np.exp(-distance / np.where(reach > 0, reach, 1.0))


def standardise(columns: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """z-scores with the population deviation; flat columns become zero.

    Args:
        columns: (n, c) raw values.
        rows: (n,) bool, the rows that mean and deviation are taken over; all without.

    Returns:
        (n, c) float64.
    """
    used = columns if rows is None else columns[rows]
    mean, deviation = used.mean(axis=0), used.std(axis=0)
    informative = deviation > FLAT * np.abs(used).max(axis=0)
    scaled = (columns - mean) / np.where(informative, deviation, 1.0)
    return np.where(informative, scaled, 0.0)


class State:
    """The part of the features that follows the selection, as running extrema."""

    def __init__(self, prepared: Prepared) -> None:
        n = len(prepared.pool)
        self.prepared = prepared
        self.selectable = np.ones(n, dtype=bool)
        self.picked = 0
        self.raw = np.zeros((n, len(DYNAMIC)))
        self._extrema = np.full((n, 4), np.inf)
        self._covered = np.zeros(prepared.kernel.shape[1])
        self.raw[:, 4] = prepared.kernel.sum(axis=1)

    def add(self, row: int) -> None:
        """Append a row of the pool to the selection."""
        prepared = self.prepared
        self.selectable[row] = False
        self.picked += 1
        _running(prepared.centers, prepared.axes, prepared.bearings, row, self._extrema, self.raw)
        if prepared.descriptors.shape[1]:
            likeness = (prepared.descriptors @ prepared.descriptors[row]).astype(np.float64)
            best = likeness if self.picked == 1 else np.maximum(self.raw[:, 2], likeness)
            self.raw[:, 2] = best
        if len(self._covered):
            self._covered += prepared.kernel[row]
            self.raw[:, 4] = prepared.kernel @ (1 / (1 + self._covered))

    def inputs(self) -> np.ndarray:
        """(n, 5) standardised d_min_s, gamma_min_s, rho_max_s, phi_nov and coverage gain.

        The first four are zero before the first pick (paper, section 3.2).
        """
        values = _standardised(self.raw, self.selectable)
        if self.picked == 0:
            values[:, :4] = 0
        return values


@_jit
def _running(centers, axes, bearings, row, extrema, raw):
    """Fold one pick into the nearest distances and angles; angles only where they shrink."""
    for i in range(len(centers)):
        gap = 0.0
        axis = 0.0
        bearing = 0.0
        for c in range(3):
            gap += (centers[i, c] - centers[row, c]) ** 2
            axis += (axes[i, c] - axes[row, c]) ** 2
            bearing += (bearings[i, c] - bearings[row, c]) ** 2
        if gap < extrema[i, 0]:
            extrema[i, 0] = gap
            raw[i, 0] = np.sqrt(gap)
        if axis < extrema[i, 1]:
            extrema[i, 1] = axis
            raw[i, 1] = _angle(axes, i, row, axis)
        if bearing < extrema[i, 2]:
            extrema[i, 2] = bearing
            raw[i, 3] = _angle(bearings, i, row, bearing)


@_jit
def _angle(vectors, i, j, squared_chord):
    total = 0.0
    for c in range(3):
        total += (vectors[i, c] + vectors[j, c]) ** 2
    return 2 * np.arctan2(np.sqrt(squared_chord), np.sqrt(total))


@_jit
def _standardised(raw, rows):
    n, columns = raw.shape
    out = np.zeros((n, columns))
    count = rows.sum()
    if count == 0:
        return out
    for c in range(columns):
        total = 0.0
        scale = 0.0
        for i in range(n):
            if rows[i]:
                total += raw[i, c]
                scale = max(scale, abs(raw[i, c]))
        mean = total / count
        squares = 0.0
        for i in range(n):
            if rows[i]:
                squares += (raw[i, c] - mean) ** 2
        deviation = np.sqrt(squares / count)
        if deviation > FLAT * scale:
            for i in range(n):
                out[i, c] = (raw[i, c] - mean) / deviation
    return out


def greedy(
    prepared: Prepared, weights: dict[str, np.ndarray], k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pick k rows, the best-scored remaining one at each step (paper, Eq. 1 and 2).

    Args:
        prepared: see `prepare`.
        weights: of the scorer, float32.
        k: at most the size of the pool.

    Returns:
        (k,) int64 rows of the pool in pick order, and (k,) float64 their scores. Ties go to the
        lowest row.
    """
    first = weights["layer1.weight"]
    base = prepared.static.astype(np.float32) @ first.T + weights["layer1.bias"]
    dynamic = np.ascontiguousarray(first[:, DYNAMIC].T)
    second = np.ascontiguousarray(weights["layer2.weight"].T)

    def score(inputs: np.ndarray) -> np.ndarray:
        hidden = inputs.astype(np.float32) @ dynamic
        _add_gelu(hidden, base)
        return _head(
            hidden @ second,
            weights["layer2.bias"],
            weights["layer3.weight"][0],
            weights["layer3.bias"][0],
        )

    return run_greedy(prepared, score, k)


def run_greedy(
    prepared: Prepared, score: Callable[[np.ndarray], np.ndarray], k: int
) -> tuple[np.ndarray, np.ndarray]:
    """The greedy loop for any score of the (n, 5) inputs that follow the selection."""
    state = State(prepared)
    rows = np.empty(k, dtype=np.int64)
    scores = np.empty(k)
    for step in range(k):
        values = np.where(state.selectable, score(state.inputs()), -np.inf)
        rows[step] = np.argmax(values)
        scores[step] = values[rows[step]]
        state.add(int(rows[step]))
    return rows, scores


@numba.njit(cache=True, nogil=True, fastmath=True)
def _gelu(z):
    """Exact-GELU z Phi(z) with Eigen's rational float erf (MPL-2.0), absolute error below 5e-7."""
    x = min(max(z * np.float32(0.70710678), np.float32(-4)), np.float32(4))
    s = x * x
    p = np.float32(-2.72614225801306e-10)
    p = p * s + np.float32(2.77068142495902e-08)
    p = p * s + np.float32(-2.10102402082508e-06)
    p = p * s + np.float32(-5.69250639462346e-05)
    p = p * s + np.float32(-7.34990630326855e-04)
    p = p * s + np.float32(-2.95459980854025e-03)
    p = p * s + np.float32(-1.60960333262415e-02)
    q = np.float32(-1.45660718464996e-05)
    q = q * s + np.float32(-2.13374055278905e-04)
    q = q * s + np.float32(-1.68282697438203e-03)
    q = q * s + np.float32(-7.37332916720468e-03)
    q = q * s + np.float32(-1.42647390514189e-02)
    return np.float32(0.5) * z * (np.float32(1) + x * p / q)


@numba.njit(cache=True, nogil=True, fastmath=True)
def _add_gelu(hidden, base):
    for i in range(hidden.shape[0]):
        for j in range(hidden.shape[1]):
            hidden[i, j] = _gelu(hidden[i, j] + base[i, j])


@numba.njit(cache=True, nogil=True, fastmath=True)
def _head(hidden, bias, weight, offset):
    out = np.empty(hidden.shape[0])
    for i in range(hidden.shape[0]):
        total = offset
        for j in range(hidden.shape[1]):
            total += weight[j] * _gelu(hidden[i, j] + bias[j])
        out[i] = total
    return out


def trajectory_inputs(prepared: Prepared, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the scorer sees at each step of a given order of picks: training mirrors inference.

    Args:
        prepared: see `prepare`.
        rows: (K,) rows of the pool in order.

    Returns:
        (K, n, 19) float32 inputs, and (K, n) bool, True for rows not yet picked.
    """
    features = np.repeat(prepared.static[None].astype(np.float32), len(rows), axis=0)
    selectable = np.empty((len(rows), len(prepared.pool)), dtype=bool)
    state = State(prepared)
    for step, row in enumerate(rows):
        features[step][:, DYNAMIC] = state.inputs()
        selectable[step] = state.selectable
        state.add(int(row))
    return features, selectable


def untrained_select(problem: Problem, k: int, signs: np.ndarray) -> np.ndarray:
    """The untrained control: the sum of sign-corrected z-scores, the same greedy loop."""
    prepared = prepare(
        problem, pool="candidates", reference="proxies", appearance=True, coverage=False
    )
    full = np.append(signs, 0.0)
    base = prepared.static @ full
    rows, _ = run_greedy(prepared, lambda inputs: base + inputs @ full[DYNAMIC], k)
    return prepared.pool[rows]


def learned_method(
    name: str,
    label: str,
    scorer: Scorer,
    *,
    pool: str,
    reference: str,
    appearance: bool,
    coverage: bool,
) -> Method:
    """A trained scorer as a selection method; see `prepare` for the switches."""

    def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
        prepared = prepare(
            problem, pool=pool, reference=reference, appearance=appearance, coverage=coverage
        )
        return prepared.pool[greedy(prepared, scorer.weights, k)[0]]

    return Method(name, label, pool, nested=True, seeds=1, select=select)
