"""Jobs that an earlier run left on a Slurm cluster."""

from __future__ import annotations

import logging
import subprocess
import time
from pathlib import Path

logger = logging.getLogger(__name__)

PATIENCE = 300.0  # seconds that cancelled jobs may take to end
POLL = 2.0  # seconds between two looks at the queue


def end_earlier_jobs(prefix: str, folder: Path, patience: float = PATIENCE) -> list[str]:
    """Cancel jobs that a killed run of the workflow left behind, and wait until they are gone.

    To be called before this run submits any: jobs are known by the start of their name and by the
    folder that they run in.

    Args:
        prefix: of the jobs' names.
        folder: where the workflow runs.
        patience: seconds to wait.

    Returns:
        The numbers of the jobs that were cancelled.

    Raises:
        ValueError: when Slurm does not answer, or jobs are still there after `patience` seconds.
    """
    jobs = sorted(_queued(prefix, folder))
    if not jobs:
        return []
    logger.warning("cancelling jobs of an earlier run: %s", " ".join(jobs))
    _slurm("scancel", *jobs)
    deadline = time.monotonic() + patience
    while left := sorted(_queued(prefix, folder)):
        if time.monotonic() > deadline:
            raise ValueError(
                f"jobs {' '.join(left)} of an earlier run in {folder} are still there "
                f"{patience:.0f} seconds after scancel. Hint: `squeue -j {','.join(left)}` says "
                "whose they are; run again when they are gone"
            )
        time.sleep(POLL)
    return jobs


def _queued(prefix: str, folder: Path) -> set[str]:
    """Numbers of the jobs of all users that wait or run in `folder` under such a name."""
    lines = _slurm("squeue", "--noheader", "--format", "%i|%j|%Z").splitlines()
    jobs = [line.strip().split("|", 2) for line in lines]
    return {n for n, name, where in jobs if name.startswith(prefix) and Path(where) == folder}


def _slurm(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(f"{' '.join(command)} answers {done.returncode}: {done.stderr.strip()}")
    return done.stdout
