"""Jobs that an earlier run left on a Slurm cluster."""

from __future__ import annotations

import logging
import subprocess
import time
from collections.abc import Iterable
from pathlib import Path

logger = logging.getLogger(__name__)

PATIENCE = 300.0  # seconds that cancelled jobs may take to end
POLL = 2.0  # seconds between two looks at the queue


def end_earlier_jobs(jobs: Iterable[str], folder: Path, patience: float = PATIENCE) -> list[str]:
    """Cancel jobs that a killed run of the workflow left behind, and wait until they are gone.

    Args:
        jobs: numbers that the workflow noted for outputs which it did not see finished.
        folder: where the workflow runs; a job of that number that runs elsewhere is not ours, as
            after a restart of Slurm that began to count anew.
        patience: seconds to wait.

    Returns:
        The numbers of the jobs that were cancelled.

    Raises:
        ValueError: when Slurm does not answer, or jobs are still there after `patience` seconds.
    """
    asked = set(jobs)
    found = sorted(asked & _queued(folder))
    if not found:
        return []
    logger.warning("cancelling jobs of an earlier run: %s", " ".join(found))
    _slurm("scancel", *found)
    deadline = time.monotonic() + patience
    while left := sorted(set(found) & _queued(folder)):
        if time.monotonic() > deadline:
            raise ValueError(
                f"jobs {' '.join(left)} of an earlier run in {folder} are still there "
                f"{patience:.0f} seconds after scancel. Hint: `squeue -j {','.join(left)}` says "
                "whose they are; run again when they are gone"
            )
        time.sleep(POLL)
    return found


def _queued(folder: Path) -> set[str]:
    """Numbers of the jobs that wait or run, of all users, with `folder` as their working folder."""
    lines = _slurm("squeue", "--noheader", "--format", "%i|%Z").splitlines()
    pairs = [line.strip().partition("|") for line in lines]
    return {number for number, _, where in pairs if Path(where) == folder}


def _slurm(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(f"{' '.join(command)} answers {done.returncode}: {done.stderr.strip()}")
    return done.stdout
