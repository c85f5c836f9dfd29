"""The learned methods of the sweep: one scorer, three ways of asking it."""

from __future__ import annotations

from dataclasses import dataclass

from fsel.problem import Method, Problem
from fsel.selector.greedy import Prepared, learned_method, prepare
from fsel.selector.scorer import Scorer


@dataclass(frozen=True)
class Policy:
    """What a learned method may see and pick; training and selection read the same one.

    Attributes:
        name: of the method.
        label: how tables print it (LaTeX).
        pool: `candidates` (P) or `observed` (P and O).
        reference: `proxies` or `targets`: what geometric features compare with.
        appearance: whether the four appearance features are used.
        coverage: whether the nineteenth input carries the coverage gain, and distances to the picks
            count more of them than the nearest (`fsel.features.conditioned`).
    """

    name: str
    label: str
    pool: str
    reference: str
    appearance: bool
    coverage: bool

    def prepare(self, problem: Problem) -> Prepared:
        """The greedy selection's fixed part under this policy."""
        return prepare(
            problem,
            pool=self.pool,
            reference=self.reference,
            appearance=self.appearance,
            coverage=self.coverage,
        )

    def method(self, scorer: Scorer) -> Method:
        """The selection method with a trained scorer."""
        return learned_method(
            self.name,
            self.label,
            scorer,
            pool=self.pool,
            reference=self.reference,
            appearance=self.appearance,
            coverage=self.coverage,
        )


POLICIES: dict[str, Policy] = {
    policy.name: policy
    for policy in (
        Policy(
            name="ours_no_appearance",
            label="Ours, no appearance",
            pool="candidates",
            reference="proxies",
            appearance=False,
            coverage=False,
        ),
        Policy(
            name="ours",
            label="Ours",
            pool="candidates",
            reference="proxies",
            appearance=True,
            coverage=False,
        ),
        Policy(
            name="fsel",
            label="fsel",
            pool="observed",
            reference="targets",
            appearance=False,
            coverage=True,
        ),
    )
}
"""In the order of the tables. `ours` is the paper's; `fsel` also sees the targets' poses."""
