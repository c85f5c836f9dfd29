"""Reconstructions of a job, and their minutes by what a reconstructor says it costs."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Any, NamedTuple

Section = Mapping[str, Any]

SLACK, STARTING = 1.5, 10  # minutes asked for, over those computed, and beside them


class Work(NamedTuple):
    """Reconstructions of a job.

    Attributes:
        subsets: that are fitted, at most.
        views: rendered from each.
    """

    subsets: int
    views: int

    def seconds(self, section: Section, cost: Section) -> float:
        """Seconds by the clock of a reconstructor with a cost."""
        loads = self.subsets if loads_each(section) else 1
        return float(
            loads * cost["load"] + self.subsets * (cost["fit"] + self.views * cost["render"])
        )

    def minutes(self, section: Section, cost: Section) -> int:
        """Minutes to ask a cluster for."""
        return ceil(self.seconds(section, cost) * SLACK / 60) + STARTING


def loads_each(section: Section) -> bool:
    """Say whether a reconstructor is loaded for every subset: a program that does not serve."""
    return section["name"] == "external" and not section["settings"].get("serve")


def searched(search: Section) -> int:
    """The most subsets that a search of the configuration evaluates."""
    if search["labeller"] != "genetic":
        return int(search["evaluations"])
    children = search["population"] - search["elites"]
    return int(search["population"] + search["generations"] * children)


def label(config: Section) -> Work:
    """Work of one of the jobs that label a scene."""
    every = len(config["coverages"]) * searched(config["search"])
    return Work(ceil(every / config["label_jobs"]), config["targets"])


def search_oracle(config: Section) -> Work:
    """Work of a search that selections are compared with, and of as many random subsets."""
    return Work(2 * searched(config["search"]) + 2, config["targets"])


def evaluate(config: Section, scorers: int) -> Work:
    """Work of an evaluation of every selection of a scene; no job of a table has more.

    Args:
        config: the configuration.
        scorers: learned and fixed rules that are measured.
    """
    from fsel.selectors.baselines import METHODS

    runs = sum(METHODS[name].seeds for name in METHODS if name != "all") + scorers
    return Work(config["draws"] * (runs * len(config["budgets"]) + 1), config["targets"])
