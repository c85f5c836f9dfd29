"""Policies: what a learned or fixed scorer may see and pick, and how it scores."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsel.core.geometry import centered, directions
from fsel.core.problem import Method, Problem
from fsel.features.columns import (
    APPEARANCE,
    FEATURES,
    INPUTS,
    NAMES,
    RELATIONAL,
    SHARPNESS,
    STATIC_INPUTS,
    TARGET_GAIN,
    TARGET_GAIN_INPUT,
)
from fsel.features.conditioned import (
    NOTHING,
    SURROGATE_DECAY_START,
    closeness,
    look_depth,
    look_distance,
    look_embedding,
    nearest_view_penalty,
    visibility,
)
from fsel.features.static import SIGNS, proxy_points, static_features
from fsel.selectors.greedy import Prepared, Rows, greedy, standardise
from fsel.selectors.scorer import Linear, Network, Scorer

Ranked = Callable[[Problem, int], tuple[np.ndarray, np.ndarray]]
Loop = Callable[[Prepared, Scorer, int], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, kw_only=True)
class ScoringMethod(Method):
    """A selection method that scores frames.

    Attributes:
        scorer: with its provenance.
        ranked: (problem, k) -> (k,) int64 frames in pick order, and (k,) float64 their scores.
    """

    scorer: Scorer
    ranked: Ranked
    aimed: bool = True


@dataclass(frozen=True)
class Policy:
    """Contract of a scorer: what it sees and picks, and its kind. Training and selection read it.

    Attributes:
        name: of the method.
        label: how tables print it (LaTeX).
        pool: `candidates` (P) or `observed` (P and O).
        reference: whose poses features compare with: `proxies`, as in the paper, or `targets`.
        inputs: those of `fsel.features.columns.NAMES` that the scorer reads; others are not
            computed. With the target gain, distances to the picks are those of
            `fsel.features.conditioned`.
        kind: of the scorer: `Linear` or `Network`.
        points: whether the target gain counts the points of the views that come into view, at the
            problem's depths of the targets where it has them.
    """

    name: str
    label: str
    pool: str
    reference: str
    inputs: tuple[str, ...]
    kind: type[Scorer]
    points: bool = False

    @cached_property
    def reads(self) -> tuple[str, ...]:
        """Parts of the images that it looks at: `appearance`, `sharpness`, both or neither."""
        appearance = ("appearance",) if self._read(APPEARANCE) else ()
        return appearance + ((SHARPNESS,) if self._read([SHARPNESS]) else ())

    def _read(self, names: Iterable[str]) -> bool:
        return not set(names).isdisjoint(self.inputs)

    def without(self, inputs: Iterable[str], name: str, label: str) -> Policy:
        """Return the same policy under another name without some inputs, which its label says."""
        left = tuple(own for own in self.inputs if own not in inputs)
        return replace(self, name=name, label=f"{self.label}, {label}", inputs=left)

    def prepare(self, problem: Problem) -> Prepared:
        """Compute what no pick changes."""
        capture, frames = problem.capture, problem.pool(self.pool)
        by_targets = self.reference == "targets"
        references = problem.targets if by_targets else capture.view(problem.proxies)
        static = np.zeros((len(frames), INPUTS))
        appearance = self._read(APPEARANCE)
        if self._read((*RELATIONAL, SHARPNESS)):
            raw = problem.features  # of candidates and proxies, where they were stored
            if raw is None or by_targets or self.pool != "candidates":
                raw = static_features(problem, frames, references, appearance)
            static[:, STATIC_INPUTS] = standardise(raw)
            static[:, ~np.isin(NAMES, self.inputs)] = 0
        centers, axes = capture.centers[frames], capture.axes[frames]
        close, visible = np.zeros((len(frames), 0)), NOTHING
        known = problem.target_depths if self.points else None
        scene = look_depth(centers) if known is None else float(np.median(known))
        if self._read([TARGET_GAIN]):
            depth = np.full(len(references), scene) if known is None else known
            distance = look_distance(centers, axes, references, depth)
            close = closeness(distance)
            static[:, TARGET_GAIN_INPUT] = -nearest_view_penalty(distance)
            if self.points:
                views, two = capture.view(frames), known is not None
                visible = visibility(views, references, distance, depth, two=two)
        # angular novelty is measured from the mean of the views' reference points
        common = proxy_points(problem, references).mean(axis=0)
        rows = Rows(
            centers=centered(centers),
            axes=np.ascontiguousarray(axes),
            bearings=directions(centers, common),
            descriptors=problem.descriptors[frames][:, : None if appearance else 0],
            closeness=close,
            look_embedding=look_embedding(centers, axes, scene),
            visible=visible,
            decay_start=SURROGATE_DECAY_START if problem.targets_unknown else np.inf,
        )
        return Prepared(frames, static, rows, np.searchsorted(frames, problem.fixed_picks))

    def method(self, scorer: Scorer, pick: Loop = greedy) -> ScoringMethod:
        """Return the selection method with a scorer, picked for by a greedy loop; ValueError for a
        scorer of another kind, or one that reads what the policy does not."""
        if not isinstance(scorer, self.kind):
            raise ValueError(
                f"the policy {self.name} has a scorer of the kind {self.kind.__name__}, not "
                f"{type(scorer).__name__}"
            )
        read = scorer.coefficients if isinstance(scorer, Linear) else ()
        if others := [name for name in read if name not in self.inputs]:
            raise ValueError(
                f"the policy {self.name} does not read {', '.join(others)}; allowed: "
                f"{', '.join(self.inputs)}"
            )

        def ranked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
            prepared = self.prepare(problem)
            rows, scores = pick(prepared, scorer, k)
            return prepared.pool[rows], scores

        def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
            return ranked(problem, k)[0]

        return ScoringMethod(
            *(self.name, self.label, self.pool),
            nested=True,
            select=select,
            reads=self.reads,
            begins=pick is not greedy,
            scorer=scorer,
            ranked=ranked,
        )


LESS_IS_MORE = Policy(
    name="less_is_more",
    label="Ours",
    pool="candidates",
    reference="proxies",
    inputs=FEATURES,
    kind=Network,
)
FSEL = Policy(
    name="fsel",
    label="fsel",
    pool="observed",
    reference="targets",
    inputs=("d_min_s", "gamma_min_s", "phi_nov", TARGET_GAIN),
    kind=Linear,
    points=True,
)
POLICIES: dict[str, Policy] = {
    policy.name: policy
    for policy in (
        LESS_IS_MORE.without(APPEARANCE, "less_is_more_no_appearance", "no appearance"),
        LESS_IS_MORE,
        FSEL,
        replace(FSEL, name="fsel_rule", label="fsel, without points", points=False),
    )
}
"""Policies in the order of the tables; `less_is_more` is the paper's, `fsel` knows the targets."""

GEOMETRY = LESS_IS_MORE.without(
    (*APPEARANCE, SHARPNESS), "less_is_more_geometry", "no appearance, no sharpness"
)
KNOWN: dict[str, Policy] = {**POLICIES, GEOMETRY.name: GEOMETRY}
"""Every policy that can be trained; `GEOMETRY` is of the table of runtimes alone."""

SUM = replace(LESS_IS_MORE, name="untrained", label="Untrained sum", kind=Linear)
UNTRAINED = SUM.method(Linear(SIGNS))
"""The untrained control: the scorer's features, sign-corrected and summed (paper, Appendix D.3)."""
