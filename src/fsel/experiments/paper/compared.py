"""The reconstructors that `transfer` and `reconchoice` name, and budgets with picks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from fsel.core.files import Files
from fsel.workflow import inputs, reconstructors
from fsel.workflow.experiment import Experiment
from fsel.workflow.reconstructors import Section
from fsel.workflow.refusal import refuse
from fsel.workflow.requirements import check_reconstructors

TRANSFER, CHOICE = "transfer", "reconchoice"


def named(experiment: Experiment, table: str) -> dict[str, Section]:
    """Name -> section of each of a table's; `reconchoice` has those of `transfer` unless set."""
    own = experiment.config[table]["reconstructions"]
    given = experiment.config[TRANSFER]["reconstructions"] if own is None else own
    return reconstructors.named(given, f"{table}.reconstructions")


def programs(table: str) -> Callable[[Experiment], None]:
    """A function that refuses a table's that cannot work here."""

    def checked(experiment: Experiment) -> None:
        own = experiment.reconstructors.values()  # asked for already
        further = {name: part for name, part in named(experiment, table).items() if part not in own}
        check_reconstructors(further, f"{table}.reconstructions")

    return checked


def described(experiment: Experiment, table: str) -> dict[str, dict[str, Any]]:
    """Name -> what a caption tells of each of a table's."""
    sections = named(experiment, table)
    return {name: reconstructors.described(name, section) for name, section in sections.items()}


def of_wildcard(experiment: Experiment, table: str) -> Callable[[Any], Section]:
    """The section of the wildcard `compared`."""
    sections = named(experiment, table)

    def section(wildcards: Any) -> Section:
        if wildcards.compared not in sections:
            refuse(
                f"{table}.reconstructions has no {wildcards.compared!r}",
                f"its names are {list(sections)}",
            )
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


def of_each(evaluations: Files, names: Iterable[str]) -> dict[str, Files]:
    """Name -> its part of `files`."""
    every = list(names)
    count = len(evaluations) // len(every)
    return {name: evaluations[at * count :][:count] for at, name in enumerate(every)}


def files(experiment: Experiment, table: str, draws: Iterable[int]) -> list[str]:
    """The evaluation of every one of a table's reconstructors, held-out scene and draw."""
    scenes, numbers = inputs.held_out_scenes(experiment), list(draws)
    return [
        path
        for compared in named(experiment, table)
        for path in inputs.of_scenes(scenes, f"{compared}/{table}.parquet", numbers)
    ]
