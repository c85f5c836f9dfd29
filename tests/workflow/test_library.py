"""The library as input of every rule, and the rules that the profiles name."""

import re

import yaml
from dry_runs import ROOT

from fsel.workflow.functions import home_of

RULES = re.compile(r"^(?:use rule \w+ as (\w+) with:)(.*?)(?=^\S|\Z)", re.M | re.S)
TEXT = "\n".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk"))


def test_every_rule_depends_on_the_sources_of_its_function():
    # a download is not made anew because the code that made it has changed
    free = {"download", "unpack", "budget_curves", "fit_budget"}  # the latter two are tools
    found = {}
    for name, text in RULES.findall(TEXT):
        called = re.search(r'(?:experiment|paper)\.library\(\s*"(\w+)"', text)
        if "    input:" in text or name in free:
            found[name] = called and called[1]
    assert len(found) > 40
    for name, called in found.items():
        assert called is None if name in free else home_of(called) == home_of(name), name


def test_the_profile_for_slurm_groups_rules_that_exist():
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "profile.yaml").read_text())
    assert set(profile["groups"]) <= set(re.findall(r"^(?:rule|use rule \w+ as) (\w+)", TEXT, re.M))
