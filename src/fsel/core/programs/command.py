"""Running a program: its environment, its time, and how it ended."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from fsel.core.programs.outcome import FAILED, MEMORY, TIMEOUT, Unfinished

LOG = "log.txt"
TAIL, TAIL_BYTES = 20, 1 << 16  # of the log, that an error shows and that are read for it
FULL = re.compile(r"out of memory|OutOfMemoryError|MemoryError|Cannot allocate memory", re.I)
HIDDEN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")  # of this process, not of the program's


def environment(venv: str | None) -> dict[str, str]:
    """Return this process's variables without what would lead a program to its packages."""
    variables = {name: value for name, value in os.environ.items() if name not in HIDDEN}
    if venv is not None:
        folder = Path(venv).resolve()
        variables["VIRTUAL_ENV"] = str(folder)
        variables["PATH"] = f"{folder / 'bin'}{os.pathsep}{variables.get('PATH', os.defpath)}"
    return variables


def run(command: Sequence[str], folder: Path, variables: Mapping[str, str], timeout: float) -> None:
    """Run a command to its end, in its own process group; its output goes to log.txt.

    Args:
        command: program and arguments; no shell reads them.
        folder: where it runs, and where the log is.
        variables: its environment.
        timeout: seconds, after which its processes are killed.

    Raises:
        Unfinished: for a timeout, full memory, or another exit code than zero.
    """
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
        try:
            code = process.wait(timeout)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            kill(process.pid)  # with whatever it started and left
            process.wait()
    if code is None:
        raise Unfinished(TIMEOUT, f"{command[0]} was stopped after its time", tail(folder))
    if code:
        said = tail(folder)
        raise Unfinished(*ended(command[0], code, said), said)


def tail(folder: Path, since: int = 0) -> str:
    """Return the last lines of the log, of those from some byte on."""
    with (folder / LOG).open("rb") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - TAIL_BYTES, since))
        text = file.read().decode("utf-8", errors="replace")
    lines = text.replace("\r", "\n").splitlines()
    return "\n".join([line for line in lines if line.strip()][-TAIL:])


def ended(program: str, code: int, log: str) -> tuple[str, str]:
    """Describe a program that ended with an exit code, or by a signal below zero.

    Returns:
        The outcome, and a sentence.
    """
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
