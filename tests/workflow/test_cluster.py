"""The smoke config through the profile for Slurm, with everything that goes wrong on a cluster.

Takes minutes, and root: `python -m pytest -m slurm tests/workflow/test_cluster.py`.
"""

import os
import re
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
import single_node_slurm
from dry_runs import ROOT

TARGET = "results/smoke/tables/ksweep.tex"
TABLES = ("ksweep.tex", "ksweep.csv", "ksweep_differences.csv")
PATIENCE = 1200  # seconds for anything to happen
WANTING = single_node_slurm.missing() or (
    "" if find_spec("snakemake_executor_plugin_slurm") else "no plugin: pip install '.[slurm]'"
)
pytestmark = [pytest.mark.slurm, pytest.mark.skipif(bool(WANTING), reason=WANTING)]


@pytest.fixture
def slurm(tmp_path_factory, request):
    accounting = getattr(request, "param", False)
    if accounting and (wanting := single_node_slurm.missing(accounting)):
        pytest.skip(wanting)
    home = tmp_path_factory.mktemp("slurm")
    with single_node_slurm.running(home, accounting) as environment:
        yield environment


def snakemake(*arguments):
    command = [sys.executable, "-m", "snakemake", TARGET, "--snakefile", str(ROOT / "Snakefile")]
    return [*command, "--configfile", str(ROOT / "config" / "smoke.yaml"), *arguments]


def by_profile(*arguments):
    return snakemake("--workflow-profile", str(ROOT / "profiles" / "slurm"), *arguments)


def environment_of(slurm):
    return {**slurm, "PYTHONWARNINGS": "ignore", "PYTHONUNBUFFERED": "1"}


def start(folder, slurm):
    folder.mkdir(exist_ok=True)
    with (folder / "run.log").open("a") as log:
        return subprocess.Popen(
            by_profile(), cwd=folder, env=environment_of(slurm), stdout=log, stderr=log
        )


def running_job(slurm, run, rules, but=()):
    """Number of a running job of one of some rules or groups, once there is one."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        listed = single_node_slurm.ask(slurm, "squeue", "-h", "-t", "RUNNING", "-o", "%i %k")
        for number, comment in (line.split(" ", 1) for line in listed.splitlines()):
            if number not in but and re.match(rf"rule_({rules})", comment):
                return number
        assert run.poll() is None, "Snakemake has ended"
        time.sleep(0.3)
    raise AssertionError(f"no job of {rules} within {PATIENCE} seconds")


def fail(number):
    """Kill the script of a job; the job then ends with an error of its own."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                within = f"SLURM_JOB_ID={number}\0".encode() in (folder / "environ").read_bytes()
                script = b".snakemake/scripts" in (folder / "cmdline").read_bytes()
            except OSError:  # ended in this moment
                continue
            if within and script:
                os.kill(int(folder.name), signal.SIGKILL)
                return
        time.sleep(0.1)
    raise AssertionError(f"job {number} runs no script")


@pytest.mark.parametrize("slurm", [False, True], ids=["alone", "accounting"], indirect=True)
def test_tables_after_failed_cancelled_and_orphaned_jobs(tmp_path, slurm):
    local = subprocess.Popen(
        snakemake("--cores", "1", "--workflow-profile", str(ROOT / "profiles" / "default")),
        cwd=(folder := tmp_path / "local").mkdir() or folder,
        env=environment_of(slurm),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    folder = tmp_path / "cluster"
    run = start(folder, slurm)
    failed = running_job(slurm, run, "capture")
    fail(failed)
    cancelled = running_job(slurm, run, "label|search_oracle|refine")
    single_node_slurm.ask(slurm, "scancel", cancelled)
    orphan = running_job(slurm, run, "label|search_oracle|refine", but={cancelled})
    run.kill()
    run.wait()
    assert orphan in single_node_slurm.ask(slurm, "squeue", "-h", "-o", "%i").split()

    locked = subprocess.run(
        by_profile(), cwd=folder, env=environment_of(slurm), capture_output=True, text=True
    )
    assert locked.returncode != 0
    assert "lock" in locked.stdout + locked.stderr
    subprocess.run(by_profile("--unlock"), cwd=folder, env=environment_of(slurm), check=True)
    run = start(folder, slurm)
    assert run.wait(PATIENCE) == 0, (folder / "run.log").read_text()[-4000:]
    ended = re.findall(r"Cancelled jobs of an earlier run: (.*)", (folder / "run.log").read_text())
    assert len(ended) == 1
    assert orphan in ended[0].split()

    assert local.wait(PATIENCE) == 0
    for name in TABLES:
        tables = [tmp_path / kind / "results/smoke/tables" / name for kind in ("local", "cluster")]
        assert tables[0].read_bytes() == tables[1].read_bytes(), name


def test_without_a_lock_nothing_is_submitted(tmp_path, slurm):
    """`--profile` adds to the default profile, which takes the lock away."""
    profile = ("--profile", str(ROOT / "profiles" / "slurm"))
    default = ("--workflow-profile", str(ROOT / "profiles" / "default"))
    done = subprocess.run(
        snakemake(*profile, *default),
        cwd=tmp_path,
        env=environment_of(slurm),
        capture_output=True,
        text=True,
    )
    assert done.returncode != 0
    assert "--workflow-profile profiles/slurm" in done.stdout + done.stderr
    assert single_node_slurm.ask(slurm, "squeue", "-h", "-t", "all") == ""
