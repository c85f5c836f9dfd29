"""The greedy loop around the scorer (paper, section 3.3), without torch and without waste.

What does not change is computed once: the static features, their standardisation and their part
of the first layer. What follows the selection is kept running (see `fsel.selector.compiled`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from fsel.capture import Views
from fsel.features.conditioned import closeness, look_distance, looks, remoteness
from fsel.features.static import FLAT, proxy_points, static_features
from fsel.geometry import centered, directions
from fsel.problem import Method, Problem
from fsel.selector.scorer import INPUTS, SHAPES, Scorer, change_bounds

RELATIONAL_INPUTS = np.arange(13)
CONDITIONED_INPUTS = np.arange(13, 17)
SHARPNESS_INPUT = 17
COVERAGE_INPUT = 18
DYNAMIC = np.append(CONDITIONED_INPUTS, COVERAGE_INPUT)


def loop() -> ModuleType:
    """The compiled loop, imported when first used: numba takes longer to import than a small
    pool takes to select from (see `fsel.selector.plain`)."""
    from fsel.selector import compiled

    return compiled


@dataclass(frozen=True)
class Prepared:
    """Everything that a greedy selection needs and that no pick changes.

    Attributes:
        pool: (n,) int64 frames, ascending; the rows of everything below.
        static: (n, 19) float64 inputs less what follows the selection: standardised, but for the
            last, minus the remoteness.
        centers: (n, 3) camera centres, relative to their mean.
        axes: (n, 3) unit optical axes.
        bearings: (n, 3) unit directions from the common reference point.
        descriptors: (n, D) float32; D = 0 when appearance is switched off.
        kernel: (n, O) float64 closeness of frame and view for the coverage input; O = 0 without.
        looks: (n, 6) float64, see `closeness.looks`.
    """

    pool: np.ndarray
    static: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    bearings: np.ndarray
    descriptors: np.ndarray
    kernel: np.ndarray
    looks: np.ndarray

    @property
    def relations(self) -> tuple[np.ndarray, ...]:
        """What `compiled.fold` compares rows by."""
        return self.centers, self.axes, self.bearings, self.descriptors, self.kernel, self.looks


def prepare(
    problem: Problem, *, pool: str, reference: str, appearance: bool, coverage: bool
) -> Prepared:
    """Compute what no pick changes.

    Args:
        problem: the selection problem.
        pool: `candidates` (P) or `observed` (P and O).
        reference: `proxies`, as in the paper, or `targets`: whose poses stand for the request.
        appearance: whether the four appearance features are used.
        coverage: whether the nineteenth input, zero in the paper, carries the coverage gain; the
            distances to the picks are then those of `fsel.features.conditioned`.
    """
    frames = problem.pool(pool)
    references = reference_views(problem, reference)
    raw = static_features(problem, frames, references, appearance)
    static = np.zeros((len(frames), INPUTS))
    static[:, RELATIONAL_INPUTS] = standardise(raw[:, :13])
    static[:, SHARPNESS_INPUT] = standardise(raw[:, 13:])[:, 0]
    capture = problem.capture
    centers, axes = capture.centers[frames], capture.axes[frames]
    kernel = np.zeros((len(frames), 0))
    if coverage:
        distance = look_distance(centers, axes, references)
        kernel, static[:, COVERAGE_INPUT] = closeness(distance), -remoteness(distance)
    return Prepared(
        pool=frames,
        static=static,
        centers=centered(centers),
        axes=np.ascontiguousarray(axes),
        bearings=directions(centers, common_reference(problem, references)),
        descriptors=problem.descriptors[frames][:, : None if appearance else 0],
        kernel=kernel,
        looks=looks(centers, axes),
    )


def reference_views(problem: Problem, reference: str) -> Views:
    """Poses that stand for the request: the proxies' or the targets' own."""
    if reference == "targets":
        return problem.targets
    return problem.capture.view(problem.proxies)


def common_reference(problem: Problem, references: Views) -> np.ndarray:
    """(3,) mean of the views' reference points, from which angular novelty is measured."""
    return proxy_points(problem, references).mean(axis=0)


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
    """The part of the features that follows the selection, kept running."""

    def __init__(self, prepared: Prepared) -> None:
        n, views = prepared.kernel.shape
        self.prepared = prepared
        self.selectable = np.ones(n, dtype=bool)
        self.raw = np.zeros((len(DYNAMIC), n))
        self._remembered = loop().memory(n, views)
        loop().coverage_gain(prepared.kernel, *self._remembered[3:], self.raw[4])

    def add(self, row: int) -> None:
        """Append a row of the pool to the selection."""
        self.selectable[row] = False
        relations = self.prepared.relations
        loop().fold(row, self.selectable, relations, self._remembered, self.raw)

    def inputs(self) -> np.ndarray:
        """(n, 5) d_min_s, gamma_min_s, rho_max_s, phi_nov, standardised, and the coverage gain.

        The first four are zero before the first pick (paper, section 3.2); so is every row
        already picked. The gain keeps its unit, the closest frame of all views: as they get
        covered it fades beside the others, and the policy turns from coverage to diversity.
        """
        values = np.empty((len(self.selectable), len(DYNAMIC)))
        loop().standardise_rows(self.raw, self.selectable, values)
        return values


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

    Raises:
        ValueError: when k is not between 1 and the size of the pool.
    """
    if not 1 <= k <= len(prepared.pool):
        raise ValueError(f"k must be between 1 and the pool's {len(prepared.pool)} rows, got {k}")
    first = weights["layer1.weight"]
    base = prepared.static.astype(np.float32) @ first.T + weights["layer1.bias"]
    # copies: arrays read from a file may be read-only, for which the loop would compile anew
    narrow = (
        np.ascontiguousarray(first[:, DYNAMIC].T),
        np.ascontiguousarray(weights["layer2.weight"].T),
        weights["layer2.bias"].copy(),
        weights["layer3.weight"][0].copy(),
    )
    wide = tuple(weights[name].astype(np.float64) for name in SHAPES)
    bounds = change_bounds(wide[0][:, DYNAMIC], wide[2], wide[4][0])
    rows, scores = np.empty(k, np.int64), np.empty(k)
    loop().run(
        k,
        DYNAMIC,
        prepared.static,
        base,
        prepared.relations,
        (narrow, wide, bounds),
        rows,
        scores,
    )
    return rows, scores


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
        features[step][:, DYNAMIC] += state.inputs()
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
            problem,
            pool=pool,
            reference=reference,
            appearance=appearance,
            coverage=coverage,
        )
        return prepared.pool[greedy(prepared, scorer.weights, k)[0]]

    reads = ("appearance", "sharpness") if appearance else ("sharpness",)
    return Method(name, label, pool, nested=True, seeds=1, select=select, reads=reads)
