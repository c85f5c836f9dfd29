"""Needs of a cluster alone: no two runs in one folder, and none of a killed run's jobs."""

from __future__ import annotations

import sys
from pathlib import Path

from fsel.workflow.refusal import Refusal, refuse
from fsel.workflow.slurm import end_earlier_jobs

LOCKS = Path(".snakemake/locks")


def start_on_slurm(lock: bool, prefix: str) -> None:
    """Prepare a start on Slurm: refuse a run without a lock, end the jobs of a run that was killed.

    Args:
        lock: whether this run locks the folder.
        prefix: of its jobs' names.
    """
    if not lock:
        refuse(
            "Slurm, but no lock on the folder: two runs would write the same files",
            "`--workflow-profile profiles/slurm` replaces the default profile, "
            "`--profile` only adds to it",
        )
    if len(list(LOCKS.glob("*.output.lock"))) > 1:
        refuse(
            "another run holds a lock in this folder, and its jobs cannot be told from a dead "
            "run's",
            "wait for it; if it was killed, the same command with --unlock takes the locks away",
        )
    try:
        ended = end_earlier_jobs(prefix, Path.cwd())
    except ValueError as error:
        raise Refusal(str(error)) from error
    if ended:
        print(f"Cancelled jobs of an earlier run: {' '.join(ended)}", file=sys.stderr)
