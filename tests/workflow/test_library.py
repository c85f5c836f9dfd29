"""The library as input of every rule: an edit of a module reruns the rules that need it."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from dry_runs import ROOT

from fsel.workflow.dependencies import Library

RULE = re.compile(r"^(?:rule (\w+):|use rule (\w+) as (\w+) with:)(.*?)(?=^\S|\Z)", re.M | re.S)
WRITTEN, MADE, EDITED = 1_400_000_000, 1_500_000_000, 1_600_000_000
EDITS = ("baselines/fvs.py", "geometry.py", "report/latex.py")


def scripts() -> dict[str, tuple[str, str]]:
    """Rule -> its script, and the script whose needs are its inputs; empty where it has none."""
    found: dict[str, tuple[str, str]] = {}
    later = []
    for path in (ROOT / "workflow" / "rules").glob("*.smk"):
        for own, base, derived, text in RULE.findall(path.read_text()):
            called = re.search(r'library\(\s*"(\w+)"', text)
            started = re.search(r'"\.\./scripts/(\w+)\.py"', text)
            if own:
                found[own] = (started[1] if started else "", called[1] if called else "")
            else:
                later.append((derived, base, called, "input:" in text))
    for derived, base, called, replaced in later:
        script, inherited = found[base]
        found[derived] = (script, called[1] if called else "" if replaced else inherited)
    return found


def test_every_rule_watches_what_its_own_script_needs():
    # a download is not made anew because the code that made it has changed
    free = {"download", "unpack"}
    for rule, (script, watched) in scripts().items():
        assert watched == ("" if rule in free else script), rule


def snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "snakemake", "--configfile", "config/smoke.yaml"]
    return subprocess.run(
        [*command, "--workflow-profile", "none", "all", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONWARNINGS": "ignore"},
    )


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
    folder = tmp_path_factory.mktemp("clone")
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


@pytest.fixture(scope="module")
def after(clone) -> dict[str, set[str]]:
    """Rule -> rules that use what it makes."""
    graph = snakemake(clone, "--rulegraph").stdout
    names = dict(re.findall(r'(\d+)\[.*?label = "(\w+)', graph))
    found: dict[str, set[str]] = {name: set() for name in names.values()}
    for before, behind in re.findall(r"(\d+) -> (\d+)", graph):
        found[names[before]].add(names[behind])
    return found


@pytest.fixture(scope="module")
def needs(clone) -> dict[str, list[str]]:
    """Script -> files that it needs."""
    library = Library(clone / "src" / "fsel", {"fsel.reconstruct:RECONSTRUCTORS": ["splats"]})
    return {path.stem: library.needed(path) for path in clone.glob("workflow/scripts/*.py")}


@pytest.mark.parametrize("module", EDITS)
def test_an_edit_of_a_module_reruns_the_rules_that_need_it(clone, after, needs, module):
    needing = {rule for rule, (_, script) in scripts().items() if module in needs.get(script, ())}
    rerun, asked = set(), needing & after.keys()
    assert 0 < len(asked) < len(after) / 2 or module == "geometry.py"
    while asked:
        rerun |= asked
        asked = set().union(*(after[rule] for rule in asked)) - rerun
    path = clone / "src" / "fsel" / module
    text = path.read_text()
    path.write_text(f"{text}# edited\n")
    os.utime(path, (EDITED, EDITED))
    try:
        planned = {rule for _, rule, plan in summary(clone) if plan == "update pending"}
    finally:
        path.write_text(text)
        os.utime(path, (WRITTEN, WRITTEN))
    assert planned == rerun - {"all"}


def test_an_unknown_name_is_refused_before_any_job(clone):
    script = clone / "workflow" / "scripts" / "select.py"
    text = script.read_text()
    script.write_text(f"{text}\nfrom fsel.data.geometry import nowhere\nnowhere()\n")
    try:
        result = snakemake(clone, "--dry-run")
    finally:
        script.write_text(text)
        os.utime(script, (WRITTEN, WRITTEN))
    assert result.returncode != 0
    assert (
        "select.py: fsel.data.geometry does not define 'nowhere'" in result.stdout + result.stderr
    )
