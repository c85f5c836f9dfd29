"""Running a program: its environment, its time, its memory, and how it ended."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fsel.core.programs.nvml import Watch
from fsel.core.programs.outcome import FAILED, MEMORY, TIMEOUT, Unfinished

LOG = "log.txt"
TAIL, TAIL_BYTES = 20, 1 << 16  # of the log, that an error shows and that are read for it
FULL = re.compile(r"out of memory|OutOfMemoryError|MemoryError|Cannot allocate memory", re.I)
HIDDEN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")  # of this process, not of the program's


@dataclass(frozen=True)
class Spent:
    """Cost of a command.

    Attributes:
        seconds: by the clock.
        peak_bytes: of the GPU's memory where it is watched, else the largest resident memory of
            any of its processes; at least what this process held when it started them.
        device: `cpu`, or the GPU's name.
    """

    seconds: float
    peak_bytes: int
    device: str


def environment(venv: str | None) -> dict[str, str]:
    """This process's variables without what would lead a program to this one's packages."""
    variables = {name: value for name, value in os.environ.items() if name not in HIDDEN}
    if venv is not None:
        folder = Path(venv).resolve()
        variables["VIRTUAL_ENV"] = str(folder)
        variables["PATH"] = f"{folder / 'bin'}{os.pathsep}{variables.get('PATH', os.defpath)}"
    return variables


def run(
    command: Sequence[str], folder: Path, variables: Mapping[str, str], timeout: float, gpu: bool
) -> Spent:
    """Run a command to its end, in its own process group; its output goes to log.txt.

    Args:
        command: program and arguments; no shell reads them.
        folder: where it runs, and where the log is.
        variables: its environment.
        timeout: seconds, after which its processes are killed.
        gpu: whether the memory of a GPU is watched.

    Raises:
        Unfinished: for a timeout, full memory, or another exit code than zero.
    """
    started = time.monotonic()
    with (folder / LOG).open("ab") as log:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=dict(variables),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        timer = threading.Timer(timeout, kill, [process.pid])
        timer.start()
        try:
            with Watch(process.pid, gpu) as watch:
                _, status, usage = os.wait4(process.pid, 0)
        finally:
            timer.cancel()
            kill(process.pid)  # whatever it started and left
    seconds = time.monotonic() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        said = tail(folder)
        if seconds >= timeout:
            raise Unfinished(TIMEOUT, f"{command[0]} was stopped after its time", said)
        raise Unfinished(*ended(command[0], process.returncode, said), said)
    peak = watch.peak_bytes if gpu else usage.ru_maxrss * 1024
    return Spent(seconds, peak, watch.device)


def tail(folder: Path, since: int = 0) -> str:
    """The last lines of the log, of those from some byte on."""
    with (folder / LOG).open("rb") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - TAIL_BYTES, since))
        text = file.read().decode("utf-8", errors="replace")
    lines = text.replace("\r", "\n").splitlines()
    return "\n".join([line for line in lines if line.strip()][-TAIL:])


def ended(program: str, code: int, log: str) -> tuple[str, str]:
    """Outcome and words for a program that ended with an exit code, or by a signal below zero."""
    if FULL.search(log):
        return MEMORY, f"{program} ended with exit code {code}, out of memory"
    if code == -signal.SIGKILL:
        return MEMORY, f"{program} was killed, as the system does for memory"
    return FAILED, f"{program} ended with exit code {code}"


def kill(group: int) -> None:
    """End the processes of a group."""
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return
