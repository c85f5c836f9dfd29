"""The library as input of every rule: an edit of a module reruns the rules that need it."""

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from dry_runs import ROOT, forked

from fsel.workflow.functions import home_of

WRITTEN, MADE, EDITED = 1_400_000_000, 1_500_000_000, 1_600_000_000
RULES = re.compile(r"^(?:use rule \w+ as (\w+) with:)(.*?)(?=^\S|\Z)", re.M | re.S)
LATE = {"evaluate", "ksweep", "heatmap"}


def test_every_rule_depends_on_the_sources_of_its_function():
    # a download is not made anew because the code that made it has changed
    free = {"download", "unpack", "budget_curves", "fit_budget"}  # the latter two are tools
    found = {}
    for path in (ROOT / "workflow" / "rules").glob("*.smk"):
        for name, text in RULES.findall(path.read_text()):
            called = re.search(r'(?:experiment|paper)\.library\(\s*"(\w+)"', text)
            if "    input:" in text or name in free:
                found[name] = called and called[1]
    assert len(found) > 40
    for name, called in found.items():
        assert called is None if name in free else home_of(called) == home_of(name), name


def snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    words = ["--configfile", "config/smoke.yaml", "--workflow-profile", "none", "all"]
    return forked(folder, *words, *arguments)


def summary(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Output, rule and plan of each output."""
    result = snakemake(folder, "--summary")
    assert result.returncode == 0, result.stderr
    for line in result.stdout.splitlines()[1:]:
        output, _, rule, *_, plan = line.split("\t")
        yield output, rule, plan


@pytest.fixture(scope="module")
def clone(tmp_path_factory) -> Path:
    """A copy of the workflow and the library, with an empty file for each output of the plan."""
    folder = tmp_path_factory.mktemp("a clone")
    for name in ("src", "workflow", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "Snakefile", folder)
    for path in folder.rglob("*"):
        os.utime(path, (WRITTEN, WRITTEN))
    outputs = [folder / output for output, *_ in summary(folder)]
    for output in outputs:
        if output.suffix:
            output.parent.mkdir(parents=True, exist_ok=True)
            output.touch()
        else:
            output.mkdir(parents=True)
    for output in outputs:
        os.utime(output, (MADE, MADE))
    return folder


@pytest.mark.parametrize(
    ("module", "rerun"),
    [
        ("stages/heatmap.py", {"heatmap"}),
        ("evaluation/latex.py", {"ksweep", "heatmap"}),
        ("selectors/baselines/fvs.py", None),  # what selects, and all after it
        ("reconstruct/gaussians/__init__.py", set()),  # not of this configuration
        ("workflow/job.py", set()),
    ],
)
def test_an_edit_of_a_module_reruns_the_rules_that_need_it(clone, module, rerun):
    path = clone / "src" / "fsel" / module
    text = path.read_text()
    path.write_text(f"{text}# edited\n")
    os.utime(path, (EDITED, EDITED))
    try:
        planned = {rule for _, rule, plan in summary(clone) if plan == "update pending"}
    finally:
        path.write_text(text)
        os.utime(path, (WRITTEN, WRITTEN))
    if rerun is None:
        assert planned >= {"select", *LATE}
        assert not planned & {"generate", "ingest", "describe"}
    else:
        assert planned == rerun


def test_the_profile_for_slurm_groups_rules_that_exist():
    text = "".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk"))
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "profile.yaml").read_text())
    rules = re.findall(r"^(?:rule|use rule \w+ as) (\w+)", text, re.M)
    assert set(profile["groups"]) <= set(rules)
