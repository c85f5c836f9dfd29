"""Cases that the tables of features and scorers compare, their scenes, and their rules."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import yaml

from fsel.experiments import scheme, specs
from fsel.experiments.paper.ablation.trials import trial_case
from fsel.experiments.specs import Values
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse
from fsel.workflow.resources import Size
from fsel.workflow.schema import complete, read_schema
from fsel.workflow.settings import Scene
from fsel.workflow.tables import Job

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


@dataclass(frozen=True)
class Trained:
    """The rules that train and try a table's cases, and measure what they pick.

    Attributes:
        table: `FEATURES` or `SCORERS`.
    """

    table: str

    @property
    def trials(self) -> scheme.Trials:
        """The draws of a scene, and the picks of all cases."""
        return scheme.Trials(
            f"{__name__}:{self.table.upper()}.trials",
            self.table,
            scheme.every_draw,
            settings=lambda experiment: {key: attrgetter(key) for key in ("dataset", "scene")},
            picks=self._files,
            draws=specs.draws,
            metrics=lambda experiment: ("psnr",),
        )

    @property
    def jobs(self) -> list[Job]:
        """Both rules."""
        name = self.table
        trained = Job(
            trial_case,
            name=f"trial_{name}",
            outputs={"picks": f"<results>/trials/{name}/{{trial}}.parquet"},
            message=f"Training {name} {{wildcards.trial}} and selecting with it",
            inputs=self._read,
            params=self._settings,
            size=Size(4000, 120),
        )
        return [trained, *self.trials.jobs]

    def inputs(self, experiment: Experiment) -> Values:
        """Collect what the table's function reads."""
        measured = self.trials.measured(scenes(experiment, self.table))
        return {"evaluations": measured, "trials": self._files(experiment)}

    def told(self, experiment: Experiment) -> Values:
        """Return the scenes, and the facts of the table's caption."""
        chosen = scenes(experiment, self.table)
        facts = specs.facts_about(experiment, specs.datasets_of(chosen))
        epochs = experiment.config["trials"]["epochs"]
        return {
            "scenes": chosen,
            "facts": lambda wildcards: {**facts(wildcards), "epochs": epochs},
        }

    def _files(self, experiment: Experiment) -> list[str]:
        """The picks of every case."""
        names = cases(experiment, self.table)
        return [f"<results>/trials/{self.table}/{name}.parquet" for name in names]

    def _read(self, experiment: Experiment) -> Values:
        chosen = scenes(experiment, self.table)
        draws, kinds = range(experiment.config["draws"]), ["frames", "descriptors"]
        return {
            **inputs.captures(inputs.labelled(experiment), kinds),
            **inputs.captures(inputs.joined(chosen), kinds, prefix="validation_"),
            "trajectories": "<results>/trajectories.parquet",
            "splits": inputs.of_labelled(experiment, "splits"),
            "validation_splits": inputs.of_scenes(chosen, "split.parquet", draws),
        }

    def _settings(self, experiment: Experiment) -> Values:
        every, config = cases(experiment, self.table), experiment.config
        named = inputs.joined(scenes(experiment, self.table))
        return {
            "case": lambda wildcards: every[wildcards.trial],
            "k": experiment.budget_near(BUDGETS[self.table]),
            "scenes": list(experiment.labelled),
            "problems": [f"{scene}/draw{n}" for scene in named for n in range(config["draws"])],
            "learning_rate": config["training"]["learning_rate"],
            **{key: config["trials"][key] for key in ("seeds", "epochs")},
        }


FEATURE_SWEEP, SCORER_ARCH = Trained(FEATURES), Trained(SCORERS)
