"""Damaged artefacts are refused before a job starts."""

import os

from dry_runs import forked

from fsel.core.checksums import write
from fsel.workflow.artefacts import copies

WORKFLOW = """
from fsel.workflow.artefacts import check_artefacts

onstart:
    jobs = list(workflow.dag.needrun_jobs())
    check_artefacts(
        [path for job in jobs for path in job.input],
        [path for job in jobs for path in job.output],
    )

rule last:
    input: "made.npy"
    output: "table.tex"
    shell: "false"

rule first:
    output: "made.npy"
    shell: "echo anew > made.npy"
"""


def snakemake(folder, *words):
    return forked(folder, "--cores", "1", *words)


def test_a_damaged_input_is_refused_before_outputs_are_removed(tmp_path):
    (tmp_path / "Snakefile").write_text(WORKFLOW)
    (tmp_path / "made.npy").write_text("whole\n")
    write(tmp_path / "made.npy")
    (tmp_path / "table.tex").write_text("good")
    os.utime(tmp_path / "table.tex", ns=(10**18, 10**18))  # older than its input: the job would run
    (tmp_path / "made.npy").write_text("half")
    done = snakemake(tmp_path)
    said = done.stdout + done.stderr
    assert done.returncode != 0
    assert "made.npy: has 4 bytes, and had 6 when it was made" in said
    assert "snakemake --cores 1 --force made.npy" in said
    assert (tmp_path / "table.tex").read_text() == "good"
    done = snakemake(tmp_path, "--force", "made.npy")
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "made.npy").read_text() == "anew\n"


def test_results_of_another_checkout_are_told_before_they_are_made_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "made.npy").write_text("whole")
    assert copies(["missing.npy"]) == ""
    assert "1 result of another checkout, as made.npy" in copies(["missing.npy", "made.npy"])
    (tmp_path / ".snakemake" / "metadata").mkdir(parents=True)
    assert "--touch" in copies(["made.npy"])
    (tmp_path / ".snakemake" / "metadata" / "bWFkZS5ucHk=").write_text("{}")
    assert copies(["made.npy"]) == ""
