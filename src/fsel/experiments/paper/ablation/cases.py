"""Cases that the tables of features and scorers compare, and their scenes."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse
from fsel.workflow.schema import complete, read_schema
from fsel.workflow.settings import Scene

FEATURES, SCORERS = "feature_sweep", "scorer_arch"  # the two tables
BUDGETS = {FEATURES: 30, SCORERS: 20}  # the paper's
HINT = "scorers are in config/scorers.yaml, configurations in config/feature_sweep.csv"


@cache
def _lists(folder: Path) -> Mapping[str, Any]:
    """The scorers and the feature configurations of a folder's `config`, checked."""
    with (folder / "config" / "feature_sweep.csv").open(encoding="utf-8", newline="") as file:
        configurations = list(csv.DictReader(file))
    with (folder / "config" / "scorers.yaml").open(encoding="utf-8") as file:
        scorers = yaml.safe_load(file)
    lists = {"scorers": scorers, "configurations": configurations}
    complete(lists, read_schema(folder / "workflow" / "schemas" / "cases.schema.yaml"), HINT)
    return lists


def scorer_labels(experiment: Experiment) -> dict[str, str]:
    """Name -> printed label of every scorer, in the table's order."""
    scorers = _lists(experiment.folder)["scorers"]
    return {name: scorer["label"] for name, scorer in scorers.items()}


def feature_cases(experiment: Experiment) -> dict[str, dict[str, Any]]:
    """Number -> the paper's scorer with other features, in the table's order."""
    lists = _lists(experiment.folder)
    ours = {key: lists["scorers"]["less_is_more"][key] for key in ("module", "settings")}
    return {
        row["number"]: {
            "added": row["added"] or None,
            "shown": [n for n, mark in row.items() if mark and n not in ("number", "added")],
            **ours,
        }
        for row in lists["configurations"]
    }


def scorer_cases(experiment: Experiment) -> dict[str, dict[str, Any]]:
    """Name -> a scorer with all features, in the table's order."""
    every = next(iter(feature_cases(experiment).values()))
    return {
        name: every | {key: scorer[key] for key in ("module", "settings")}
        for name, scorer in _lists(experiment.folder)["scorers"].items()
    }


def cases(experiment: Experiment, table: str) -> dict[str, dict[str, Any]]:
    """Name -> case of one of the tables."""
    return {FEATURES: feature_cases, SCORERS: scorer_cases}[table](experiment)


def scenes(experiment: Experiment, table: str) -> list[Scene]:
    """The scenes that a table's rows are compared on, at least one."""
    named = experiment.config["trials"]["scenes"][table]
    if named:
        entries = experiment.datasets.entries
        chosen = [
            (d, s) for d, role in named.items() if d in entries for s in experiment.scenes(d, role)
        ]
        if not chosen:
            refuse(
                f"trials.scenes.{table} is {named}, of which no scene is there",
                "leave it out for the validation scenes of all datasets",
            )
        return chosen
    every = experiment.with_role("validation")
    if not every:
        refuse(
            "no dataset has validation scenes",
            "features and scorers are compared on them unless trials.scenes says otherwise",
        )
    return every
