"""Every rule has what the function of its script takes, and nothing more."""

import ast
import importlib
import itertools
import json
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from dry_runs import ROOT
from snakemake.iocontainers import Namedlist

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
    unnamed = len(values) - sum(len(v) if isinstance(v, list) else 1 for _, v in values.items())
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


def function_run_by(script):
    """The function that a script hands to `run`."""
    tree = ast.parse((ROOT / "workflow" / "scripts" / f"{script}.py").read_text())
    (called,) = [
        node.args[1].id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "run"
    ]
    (home,) = [
        node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and called in [name.name for name in node.names]
    ]
    return home, called


@pytest.fixture(scope="module")
def bound(rules):
    """The rules whose scripts take their arguments by name."""
    scripts = ROOT / "workflow" / "scripts"
    found = [r for r in rules if "run(snakemake" in (scripts / f"{r['script']}.py").read_text()]
    assert len(found) > 15
    return found


def test_every_rule_has_what_its_function_takes(bound):
    for rule in bound:
        home, name = function_run_by(rule["script"])
        function = getattr(importlib.import_module(home), name)
        refused = []
        for several in (False, True):
            try:
                arguments(handed(rule, several), function, "digest")
            except TypeError as error:
                refused.append(str(error))
        assert len(refused) < 2, refused


def test_rule_script_module_and_function_have_one_name(bound):
    """An experiment's module may hold all of its rules: selection, evaluation and table."""
    by_script = itertools.groupby(sorted(bound, key=lambda r: r["script"]), lambda r: r["script"])
    for script, sharing in by_script:
        home, name = function_run_by(script)
        assert name == script
        assert home.rpartition(".")[2] == name or home.startswith("fsel.experiments.")
        names = [rule["name"] for rule in sharing]
        assert script in names or len(names) > 1
