"""Jobs of a killed run are found by name and folder, cancelled, and waited for."""

import os

import pytest

from fsel.workflow import slurm

QUEUE = """#!/bin/sh
cat queue
"""
CANCEL = """#!/bin/sh
echo "$@" >> cancelled
"""


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    """A queue in a file; what is cancelled is noted, and ends when the test says so."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(slurm, "POLL", 0.01)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    for name, script in (("squeue", QUEUE), ("scancel", CANCEL)):
        (tmp_path / name).write_text(script)
        (tmp_path / name).chmod(0o755)

    def queue(*lines):
        (tmp_path / "queue").write_text("".join(f"{line}\n" for line in lines))

    return queue


def test_only_jobs_of_that_name_and_folder_are_cancelled(cluster, tmp_path):
    (tmp_path / "scancel").write_text(CANCEL + ": > queue\n")
    cluster(f"7|fsel_1|{tmp_path}", f"8|mine|{tmp_path}", "9|fsel_1|/x", f"12_3|fsel_2|{tmp_path}")
    assert slurm.end_earlier_jobs("fsel", tmp_path) == ["12_3", "7"]
    assert (tmp_path / "cancelled").read_text() == "12_3 7\n"


def test_without_such_jobs_nothing_is_cancelled(cluster, tmp_path):
    cluster("9|fsel_1|/elsewhere")
    assert slurm.end_earlier_jobs("fsel", tmp_path) == []
    assert not (tmp_path / "cancelled").exists()


def test_jobs_that_stay_are_refused_by_number(cluster, tmp_path):
    cluster(f"7|fsel_1|{tmp_path}")
    with pytest.raises(ValueError, match=r"jobs 7 of an earlier run .*`squeue -j 7`"):
        slurm.end_earlier_jobs("fsel", tmp_path, patience=0.05)


def test_a_silent_controller_is_named(cluster, tmp_path):
    (tmp_path / "squeue").write_text("#!/bin/sh\necho down >&2\nexit 1\n")
    with pytest.raises(ValueError, match=r"squeue .* answers 1: down"):
        slurm.end_earlier_jobs("fsel", tmp_path)
