"""Every rule has what its function takes, and nothing more."""

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from dry_runs import ROOT
from snakemake.iocontainers import Namedlist

from fsel.workflow.functions import function_of
from fsel.workflow.job import arguments

RULES = """
import json, sys
from pathlib import Path
from snakemake.api import SnakemakeApi
from snakemake.settings.types import ConfigSettings, OutputSettings, Quietness, ResourceSettings

root = Path(sys.argv[1])
config = ConfigSettings(configfiles=[root / "config" / "smoke.yaml"])

def shape(values):
    # a function says only when it is called whether it gives one file or several
    found = {}
    for name, value in values.items():
        several = isinstance(value, list | tuple)
        found[name] = "either" if callable(value) else "list" if several else "one"
    counted = sum(len(v) if isinstance(v, list) else 1 for _, v in values.items())
    unnamed = len(values) - counted
    return {"named": found, "unnamed": unnamed}

with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
    workflow = api.workflow(ResourceSettings(), config, snakefile=root / "Snakefile")._workflow
    print(json.dumps([
        {
            "name": rule.name,
            "script": Path(rule.script).stem,
            "input": shape(rule.input),
            "output": shape(rule.output),
            "params": {"named": dict.fromkeys(rule.params.keys(), "one"), "unnamed": 0},
            "wildcards": {"named": dict.fromkeys(rule.wildcard_names, "one"), "unnamed": 0},
        }
        for rule in workflow.rules if rule.script
    ]))
"""


@pytest.fixture(scope="module")
def rules(tmp_path_factory):
    done = subprocess.run(
        [sys.executable, "-c", RULES, str(ROOT)],
        cwd=tmp_path_factory.mktemp("rules"),
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONWARNINGS": "ignore"},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def handed(rule, several):
    """The rule's object, with values in place of what is known once the wildcards are."""

    def listed(kind):
        found = Namedlist(toclone=["unnamed"] * rule[kind]["unnamed"])
        for name, shape in rule[kind]["named"].items():
            start = len(found)
            if shape == "list" or (shape == "either" and several):
                found.append(f"folder/{name}")
                found._set_name(name, start, end=len(found))
            else:
                found.append(f"folder/{name}")
                found._set_name(name, start)
        return found

    kinds = {kind: listed(kind) for kind in ("input", "output", "params", "wildcards")}
    return SimpleNamespace(rule=rule["name"], threads=1, **kinds)


@pytest.fixture(scope="module")
def run(rules):
    """The rules that the runner runs."""
    found = [rule for rule in rules if rule["script"] == "run" and rule["output"]["named"]]
    assert len(found) > 15
    return found


def test_every_rule_has_what_its_function_takes(run):
    for rule in run:
        function = function_of(rule["name"])
        refused = []
        for several in (False, True):
            try:
                arguments(handed(rule, several), function)
            except TypeError as error:
                refused.append(str(error))
        assert len(refused) < 2, refused


def test_a_rule_is_named_as_its_function_or_a_variant_of_it(run):
    names = {rule["name"] for rule in run}
    assert {"train", "train_no_appearance", "ingest_masked", "features_labelled"} <= names
    for rule in run:
        function = function_of(rule["name"])
        verbs = [name.split("_")[0] for name in (rule["name"], function.__name__)]
        assert rule["name"] in (function.__name__, "teaser") or verbs[0] == verbs[1], rule["name"]
