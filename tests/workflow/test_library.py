"""The library as a param of every rule, and the rules that the profiles name."""

import re

import yaml
from dry_runs import ROOT

from fsel.workflow.functions import home_of

RULES = re.compile(r"^(?:use rule (\w+) as (\w+) with:)(.*?)(?=^\S|\Z)", re.M | re.S)
TEXT = "\n".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk"))


def test_every_rule_depends_on_the_sources_of_its_function():
    # a download is not made anew because the code that made it has changed
    free = {"download", "unpack"}
    shared = {"table", "select_trials", "evaluate_trials"}
    rules = {name: (parent, text) for parent, name, text in RULES.findall(TEXT)}
    assert len(rules) > 50

    def module(name: str) -> str:
        return home_of(name).partition(":")[0]

    def called(name: str) -> str | None:
        parent, text = rules.get(name, (None, ""))
        own = re.search(r'(?:experiment|paper)\.library\(\s*"(\w+)"', text)
        return own[1] if own else parent and called(parent)

    for name in set(rules) - shared:
        own = called(name)
        # a source among the inputs would be sought in a storage of results
        assert "lib=" not in rules[name][1].partition("    output:")[0], name
        assert own is None if name in free else module(own) == module(name), name


def test_the_profile_for_slurm_groups_rules_that_exist():
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "profile.yaml").read_text())
    assert set(profile["groups"]) <= set(re.findall(r"^(?:rule|use rule \w+ as) (\w+)", TEXT, re.M))
