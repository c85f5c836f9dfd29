"""The reconstructors that `transfer` of the configuration names, and budgets with picks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from fsel.workflow import inputs, reconstructors
from fsel.workflow.experiment import Experiment
from fsel.workflow.reconstructors import Section
from fsel.workflow.refusal import refuse
from fsel.workflow.requirements import check_reconstructors

WHERE = "transfer.reconstructions"


def named(experiment: Experiment) -> dict[str, Section]:
    """Name -> section of each of them."""
    return reconstructors.named(experiment.config["transfer"]["reconstructions"], WHERE)


def check(experiment: Experiment) -> None:
    """Refuse those that cannot work here, and budgets without picks."""
    check_reconstructors(named(experiment), WHERE)
    for key in ("budgets", "inputs"):
        budgets(experiment, key)


def described(experiment: Experiment) -> dict[str, dict[str, Any]]:
    """Name -> what a caption tells of each of them."""
    sections = named(experiment)
    return {name: reconstructors.described(name, section) for name, section in sections.items()}


def of_wildcard(experiment: Experiment) -> Callable[[Any], Section]:
    """The section of the wildcard `compared`."""
    sections = named(experiment)

    def section(wildcards: Any) -> Section:
        if wildcards.compared not in sections:
            refuse(f"{WHERE} has no {wildcards.compared!r}", f"its names are {list(sections)}")
        return sections[wildcards.compared]

    return section


def budgets(experiment: Experiment, key: str) -> list[int]:
    """`budgets` or `inputs` of the section, refused where no picks exist."""
    chosen: list[int] = experiment.config["transfer"][key]
    swept = experiment.config["budgets"]
    if missing := [k for k in chosen if k not in swept]:
        refuse(
            f"transfer.{key} has {missing}, which are not among budgets {swept}",
            "nothing is selected for these tables; picks of the sweep are taken",
        )
    return chosen


def draws(experiment: Experiment) -> range:
    """The draws that are measured."""
    return range(min(experiment.config["draws"], experiment.config["transfer"]["draws"]))


def files(experiment: Experiment, name: str, draws: Iterable[int]) -> list[str]:
    """A file of every one of them, held-out scene and draw; `{compared}` stands for its name."""
    scenes, numbers = inputs.held_out_scenes(experiment), list(draws)
    return [
        path
        for compared in named(experiment)
        for path in inputs.of_scenes(scenes, f"{compared}/{name}", numbers)
    ]
