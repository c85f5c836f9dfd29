"""Cases of the tables of features and scorers, from `feature_sweep.csv` and `scorers.yaml`."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache
from typing import Any

from fsel.workflow import inputs, scenes
from fsel.workflow.experiment import Experiment
from fsel.workflow.schema import complete, read_schema, read_yaml
from fsel.workflow.settings import Locate

HINT = "scorers are in config/scorers.yaml, configurations in config/feature_sweep.csv"


@cache
def _lists(locate: Locate) -> Mapping[str, Any]:
    """Read and check the scorers and the feature configurations of the workflow's `config`."""
    with open(locate("config/feature_sweep.csv"), encoding="utf-8", newline="") as file:
        configurations = list(csv.DictReader(file))
    lists = {
        "scorers": read_yaml(locate("config/scorers.yaml")),
        "configurations": configurations,
    }
    complete(lists, read_schema(locate("workflow/schemas/cases.schema.yaml")), HINT)
    return lists


def scorer_labels(experiment: Experiment) -> dict[str, str]:
    """Map every scorer to its printed label, in the table's order."""
    scorers = _lists(experiment.locate)["scorers"]
    return {name: scorer["label"] for name, scorer in scorers.items()}


def feature_cases(experiment: Experiment) -> dict[str, dict[str, Any]]:
    """Map every row's number to the paper's scorer with its features, in the table's order."""
    lists = _lists(experiment.locate)
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
    """Map every name to a scorer with all features, in the table's order."""
    every = next(iter(feature_cases(experiment).values()))
    return {
        name: every | {key: scorer[key] for key in ("module", "settings")}
        for name, scorer in _lists(experiment.locate)["scorers"].items()
    }


def files(experiment: Experiment, table: str) -> dict[str, Any]:
    """Return the inputs of a case of `feature_sweep` or `scorer_arch`: labels, and its scenes."""

    def validation(*of: Any) -> Any:
        return lambda wildcards: inputs.of_scenes(scenes.tried(experiment, table), *of)

    return {
        **inputs.captures(inputs.labelled(experiment), inputs.DESCRIBED),
        "splits": inputs.of_labelled(experiment, "splits"),
        "trajectories": lambda wildcards: scenes.from_labels(
            experiment, "<results>/trajectories.parquet"
        ),
        **{f"validation_{kind}": validation(inputs.FILES[kind]) for kind in inputs.DESCRIBED},
        "validation_splits": validation("split.parquet", range(experiment.config["draws"])),
    }


def training(experiment: Experiment, table: str) -> dict[str, Any]:
    """Return how the cases of a table are trained, and the names of their scenes."""
    config = experiment.config
    return {
        "scenes": list(experiment.labelled),
        "problems": lambda wildcards: scenes.problems(
            scenes.tried(experiment, table), range(config["draws"])
        ),
        "learning_rate": config["training"]["learning_rate"],
        **{key: config["trials"][key] for key in ("seeds", "epochs")},
    }


def of_table(experiment: Experiment, table: str) -> dict[str, Any]:
    """Return params of a table: its `scenes`, and the `facts` for its caption."""
    params = scenes.of_table(experiment, lambda made: scenes.tried(made, table))
    epochs = {"epochs": experiment.config["trials"]["epochs"]}
    return {**params, "facts": lambda wildcards: params["facts"](wildcards) | epochs}
