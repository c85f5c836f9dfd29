"""What the tables of features and scorers compare; functions only."""

import csv
from functools import cache
from pathlib import Path

import yaml
from snakemake.exceptions import WorkflowError
from snakemake.utils import validate


@cache
def case_tables():
    """The scorers and the feature configurations that `config` lists, checked."""
    folder = Path(workflow.basedir, "config")
    with (folder / "feature_sweep.csv").open(encoding="utf-8", newline="") as file:
        configurations = list(csv.DictReader(file))
    with (folder / "scorers.yaml").open(encoding="utf-8") as file:
        scorers = yaml.safe_load(file)
    found = {"scorers": scorers, "configurations": configurations}
    try:
        validate(found, "../schemas/cases.schema.yaml")
    except WorkflowError as error:
        fault = error.__context__
        refuse(
            f"{fault.json_path.removeprefix('$.')}: {fault.message}",
            "scorers are in config/scorers.yaml, configurations in config/feature_sweep.csv",
        )
    return found


def scorers():
    """Name -> label, module and settings of every scorer, in the table's order."""
    return case_tables()["scorers"]


@cache
def feature_cases():
    """Number -> the paper's scorer with other features, in the table's order."""
    ours = {key: scorers()["less_is_more"][key] for key in ("module", "settings")}
    return {
        row["number"]: {
            "added": row["added"] or None,
            "shown": [
                name
                for name, mark in row.items()
                if mark and name not in ("number", "added")
            ],
            **ours,
        }
        for row in case_tables()["configurations"]
    }


@cache
def scorer_cases():
    """Name -> a scorer with all features, in the table's order."""
    every = next(iter(feature_cases().values()))
    return {
        name: every | {key: scorer[key] for key in ("module", "settings")}
        for name, scorer in scorers().items()
    }


def cases(table):
    return {"feature_sweep": feature_cases, "scorer_arch": scorer_cases}[table]()


def trial_budget(table):
    """The paper's budget for a table, or the nearest below."""
    return budget_near({"feature_sweep": 30, "scorer_arch": 20}[table])


def trial_scenes(table):
    """(dataset, scene) of every scene that a table's rows are compared on."""
    named = config["trials"]["scenes"][table]
    if named:
        found = [
            (d, s) for d, r in named.items() if d not in MISSING for s in scenes(d, r)
        ]
        if not found:
            refuse(
                f"trials.scenes.{table} is {named}, of which no scene is there",
                "leave it out for the validation scenes of all datasets",
            )
        return found
    found = [(d, s) for d in config["datasets"] for s in scenes(d, "validation")]
    if not found:
        refuse(
            "no dataset has validation scenes",
            "features and scorers are compared on them unless trials.scenes says otherwise",
        )
    return found


def of_trial_scenes(name, draws=(), table=None):
    """Input function: a file of every scene of a table, or of each of its draws."""
    middle = [f"draw{n}/" for n in draws] or [""]
    return lambda wildcards: [
        f"<results>/{d}/{s}/{part}{name}"
        for d, s in trial_scenes(table or wildcards.table)
        for part in middle
    ]


def of_trials(table):
    """Input function: the picks of every case of a table."""
    return lambda wildcards: [
        f"<results>/trials/{table}/{name}.parquet" for name in cases(table)
    ]


def trial_facts(table):
    """What a table's caption tells."""
    names = list(dict.fromkeys(d for d, _ in trial_scenes(table)))
    return facts(names) | {"epochs": config["trials"]["epochs"]}
