"""What is tried: ways to learn, and sets of inputs."""

from __future__ import annotations

from typing import NamedTuple

from fsel.experiments.learning.inputs import GROUPS

EVERY = tuple(GROUPS)
RULE_READS = ("gain", "company")
PAPER = ("relation", "nearest", "sharpness")


class Learner(NamedTuple):
    """A way to learn.

    Attributes:
        label: how tables print it.
        how: key of `fsel.experiments.learning.learn.WAYS`.
        on_rule: whether the network is added to the rule's score.
        start: the learner whose networks it goes on from; None for new ones.
        together: whether the networks of all seeds score together, by their mean.
    """

    label: str
    how: str
    on_rule: bool = True
    start: str | None = None
    together: bool = False


LEARNERS: dict[str, Learner] = {
    "alone": Learner("imitation, the network alone", "imitate", on_rule=False),
    "imitation": Learner("imitation, added to the rule", "imitate"),
    "average": Learner("the same, seeds averaged", "keep", start="imitation", together=True),
    "dagger": Learner("then DAgger", "dagger", start="imitation"),
    "ranking": Learner("ranking of whole subsets, added to the rule", "rank"),
    "swaps": Learner("ranking of swaps, added to the rule", "rank_swaps"),
    "swaps_average": Learner("that, seeds averaged", "keep", start="swaps", together=True),
    "gradient": Learner("policy gradient, from the rule", "gradient"),
    "evolution": Learner("then evolution of the last layer", "evolve", start="imitation"),
}
"""In the order of the table, each start before what goes on from it."""


class InputCase(NamedTuple):
    """A set of inputs.

    Attributes:
        label: how tables print it.
        groups: keys of `GROUPS`.
        reference: the case that it is compared with; empty for those.
    """

    label: str
    groups: tuple[str, ...]
    reference: str = ""


def _input_cases() -> dict[str, InputCase]:
    found = {
        "rule_reads": InputCase("what the rule reads", RULE_READS),
        "paper": InputCase("the paper's", PAPER, "rule_reads"),
    }
    for name in EVERY:
        if name not in RULE_READS:
            label = f"with {GROUPS[name].label}"
            found[f"with_{name}"] = InputCase(label, (*RULE_READS, name), "rule_reads")
    found["every"] = InputCase("all", EVERY)
    for name in EVERY:
        rest = tuple(other for other in EVERY if other != name)
        found[f"without_{name}"] = InputCase(f"without {GROUPS[name].label}", rest, "every")
    return found


INPUT_CASES = _input_cases()
"""One group added to what the rule reads, or left out of all."""
