"""Answers that a run is asked for instead of files: an overlay to fill in, and what a run costs.

snakemake overlay --configfile config/paper.yaml > mine.yaml
snakemake costs --configfile config/paper.yaml mine.yaml
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import yaml

from fsel.experiments.paper import compared
from fsel.experiments.paper.transfer import SHOWN
from fsel.workflow import work
from fsel.workflow.datasets import ROLES, count_of
from fsel.workflow.experiment import Experiment
from fsel.workflow.work import Section, Work

HOUR = 3600
FRAMES = 300  # of a capture that was not counted
HEAD = """\
# Your own part of a configuration: change what is below, remove what stays as it is, and give the
# file after the other one; keys of later files win, lists are replaced whole.
#   snakemake -n paper --configfile {given} mine.yaml
# `root` holds one folder a scene; `fetch: null` takes a download back; `scenes` are numbers of
# folders in natural order, or names: {{evaluation: [a, b], train: [c]}}.
"""


def answer(arguments: Sequence[str], experiment: Experiment, config: Section) -> None:
    """Print what the command line asks for, and end; return where it asks for files.

    Args:
        arguments: of Snakemake's command line.
        experiment: the run's, of the datasets that are there.
        config: the checked configuration, with all datasets.

    Raises:
        SystemExit: after an answer.
    """
    if "overlay" in arguments:
        files = [word for word in arguments if word.endswith((".yaml", ".yml"))]
        print(HEAD.format(given=" ".join(files)) + overlay(config), end="")
        sys.exit(0)
    if "costs" in arguments:
        print(costs(experiment, config))
        sys.exit(0)


def overlay(config: Section) -> str:
    """Configuration file of what depends on where things are, with example values."""
    content: dict[str, Any] = {"pathvars": {"results": config["pathvars"]["results"]}}
    content["datasets"] = {
        name: _with_root(name, entry)
        for name, entry in config["datasets"].items()
        if not entry.get("embedded")
    }
    for key in ("reconstruction", "transfer", "reconchoice"):
        part = config[key]
        own = part if key == "reconstruction" else {"reconstructions": part["reconstructions"]}
        content[key] = own
    for key in ("appearance", "lpips"):
        content[key] = {"weights": config[key]["weights"]}
    text: str = yaml.dump(content, Dumper=_Plain, sort_keys=False, width=100)
    return text


def _with_root(name: str, entry: Section) -> dict[str, Any]:
    found: dict[str, Any] = {"fetch": None} if entry.get("fetch") else {}
    found |= {"root": entry.get("root") or f"/data/{name}", "scenes": entry["scenes"]}
    if entry["layout"] == "scannet":  # the object of every scene
        found["reading"] = {"instance": entry["reading"].get("instance") or {"scene0000_00": 5}}
    return found


class _Plain(yaml.SafeDumper):
    """Dumper without anchors: each part can be changed alone."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def costs(experiment: Experiment, config: Section) -> str:
    """A table of jobs and hours with the costs that reconstructors state, served and not."""
    lines = ["rule                 reconstructor     jobs  subsets   hours  not served", "-" * 70]
    totals = [0.0, 0.0]
    jobs = 0
    for rule, section, count, each in _jobs(experiment, config):
        cost, name = experiment.cost_of(section), section["name"]
        head = f"{rule:20} {_named(experiment, section):16} {count:5} {count * each.subsets:8}"
        jobs += count
        if cost is None:
            lines.append(f"{head}  {name} states no cost")
            continue
        hours = [count * each.seconds(way, cost) / HOUR for way in (section, _alone(section))]
        totals = [sum(pair) for pair in zip(totals, hours, strict=True)]
        lines.append(f"{head} {hours[0]:7.0f} {hours[1]:11.0f}")
    lines += ["-" * 70, f"{'in all':37} {jobs:5} {'':8} {totals[0]:7.0f} {totals[1]:11.0f}"]
    scenes = sum(count_of(entry, role) for entry in config["datasets"].values() for role in ROLES)
    wide = config["long_side"]
    size = scenes * FRAMES * wide * round(wide * 9 / 16) * 3 / 1e9
    lines.append(
        f"{scenes} captures; images of {wide} pixels, {FRAMES} frames each, 16:9: {size:.0f} GB"
    )
    lines.append("hours are of a GPU where the reconstructor takes one; subsets are the most")
    return "\n".join(lines)


def _alone(section: Section) -> Section:
    """The same reconstructor as a program that is started for every subset."""
    settings = {key: value for key, value in section["settings"].items() if key != "serve"}
    return {**section, "settings": settings}


def _named(experiment: Experiment, section: Section) -> str:
    """Name of a reconstructor in files."""
    tables = [compared.named(experiment, table) for table in (compared.TRANSFER, compared.CHOICE)]
    for known in (experiment.reconstructors, *tables):
        for name, own in known.items():
            if own == section:
                return name
    return str(section["name"])


def _jobs(experiment: Experiment, config: Section) -> list[tuple[str, Section, int, Work]]:
    """Rule, reconstructor, jobs, and the work of each, of what takes most of the time."""
    entry = config["datasets"][experiment.trained]
    labelled = sum(count_of(entry, role) for role in ("train", "validation"))
    evaluated = sum(count_of(other, "evaluation") for other in config["datasets"].values())
    held_out, transfer = count_of(entry, "evaluation"), config["transfer"]
    views, first = config["targets"], experiment.reconstruction
    jobs = [("label", experiment.labeller, labelled * config["label_jobs"], work.label(config))]
    searches = held_out * config["oracle"]["draws"]
    jobs.append(("search_oracle", first, searches, work.search_oracle(config)))
    every = experiment.evaluated(config)
    jobs += [("evaluate", own, evaluated, every) for own in experiment.reconstructors.values()]
    draws = len(compared.draws(experiment))
    picked = Work(draws * len(SHOWN) * len(transfer["budgets"]), views)
    chosen = Work(len(transfer["inputs"]) + 1, views)
    for table, each in ((compared.TRANSFER, picked), (compared.CHOICE, chosen)):
        sections = compared.named(experiment, table).values()
        jobs += [(f"evaluate_{table}", own, held_out, each) for own in sections]
    return jobs
