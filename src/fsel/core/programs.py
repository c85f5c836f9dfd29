"""Programs that are run: their settings, time and memory, and how they end."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

FAILED = "failed"
TIMEOUT = "timeout"
MEMORY = "out of memory"
MISSING = "no image"
RANGE = "not finite"
FINISHED = ""
LOG = "log.txt"
TAIL, TAIL_BYTES = 20, 1 << 16  # of the log, that an error shows and that are read for it
FULL = re.compile(r"out of memory|OutOfMemoryError|MemoryError|Cannot allocate memory", re.I)
HIDDEN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")  # of this process, not of the program's
FOLDER, RECIPES, HERE, PYTHON = "{folder}", "{recipes}", "{here}", "{python}"
PLACES = (FOLDER, RECIPES, HERE, PYTHON)
MARK = re.compile(r"\{[a-z_]+\}")


class NoDevice(OSError):
    """Error that a program works on a GPU, and there is none here."""


class MissingRequirement(ValueError):
    """Error that a program lacks what it needs; each thing is on a line of the message."""


class Unfinished(RuntimeError):
    """A reconstruction without the images that it was to make.

    Evaluations go on: tables show the outcome, one of the words above, in the place of numbers.
    Searches stop: a subset that was not measured cannot be ranked.
    """

    def __init__(self, outcome: str, message: str, log: str = "") -> None:
        super().__init__(f"{message}\n{log}" if log else message)
        self.outcome, self.log = outcome, log or message


@dataclass(frozen=True)
class Program(ABC):
    """A program of one's own; a subclass adds its commands, which no shell reads.

    In their words `{folder}` stands for the folder that they run in, `{recipes}` for the scripts
    that come with this library, `{here}` for this process's folder, `{python}` for its interpreter.

    Attributes:
        venv: folder of a virtual environment whose programs come first; null for none.
        prefix: words before each command, such as `[conda, run, -n, nerf]`, `[apptainer, exec,
            --nv, image.sif]` or `[env, CUDA_VISIBLE_DEVICES=0]`.
        timeout: seconds that each command, or answer of a worker, may take.
        gpu: whether it works on a GPU, of NVIDIA's.
        files: path -> how to get it, of each file or folder that must be there before a run;
            `{here}` as in the commands.
    """

    venv: str | None = None
    prefix: tuple[str, ...] = ()
    timeout: float = 7200.0
    gpu: bool = False
    files: Mapping[str, str] = field(default_factory=dict)

    recipes: ClassVar = Path(__file__).parents[1] / "reconstruct" / "external" / "recipes"

    def __post_init__(self) -> None:
        object.__setattr__(self, "prefix", words_of("prefix", self.prefix))
        if isinstance(self.timeout, bool) or not 0 < self.timeout < float("inf"):
            raise ValueError(f"timeout must be seconds above zero, got {self.timeout!r}")
        if not isinstance(self.gpu, bool):
            raise ValueError(f"gpu must be true or false, got {self.gpu!r}")
        if not isinstance(self.venv, str | None):
            raise ValueError(f"venv must be a folder or null, got {self.venv!r}")
        if not isinstance(self.files, Mapping) or not all(
            isinstance(word, str) for pair in self.files.items() for word in pair
        ):
            raise ValueError(f"files must map paths to words, got {self.files!r}")
        words_of("files", list(self.files))

    @property
    @abstractmethod
    def commands(self) -> Sequence[tuple[str, ...]]:
        """Words of all its commands."""

    def command(self, words: tuple[str, ...], folder: Path) -> list[str]:
        """Return the command to run: the prefix, and the words with the places filled in."""
        return [*self.prefix, *(self._filled(word, folder) for word in words)]

    def run(self, words: tuple[str, ...], folder: Path) -> None:
        """Run one of the commands in a folder to its end; see `run`."""
        run(self.command(words, folder), folder, environment(self.venv), self.timeout)

    def missing(self) -> list[Exception]:
        """List what it needs and is not here: files, an environment, a program, a GPU."""
        found: list[Exception] = [
            FileNotFoundError(f"{path.replace(HERE, '.')} is missing: {how}")
            for path, how in self.files.items()
            if not Path(self._filled(path, Path())).exists()
        ]
        named = [word for words in self.commands for word in words if word.startswith(RECIPES)]
        known = ", ".join(sorted(path.name for path in self.recipes.glob("*.py")))
        found += [
            FileNotFoundError(f"no recipe {word!r}; allowed: {known}")
            for word in named
            if not Path(self._filled(word, Path())).is_file()
        ]
        if self.venv is not None and not (Path(self.venv) / "bin").is_dir():
            found.append(FileNotFoundError(f"venv: no virtual environment in {self.venv}"))
        elif (program := self._absent()) is not None:
            found.append(FileNotFoundError(program))
        if self.gpu and shutil.which("nvidia-smi") is None:
            found.append(NoDevice("gpu is true, but no NVIDIA driver was found (nvidia-smi)"))
        return found

    def _absent(self) -> str | None:
        """Say which first word of a command is no program; None if all are there."""
        path = environment(self.venv).get("PATH", os.defpath)
        for words in self.commands:
            program = self.command(words, Path())[0]
            if os.path.dirname(program) and not os.path.isabs(program):
                return f"no program {program!r} where it runs. Hint: {HERE}/{program}"
            if shutil.which(program, path=path) is None:
                return f"no program {program!r} in {path}"
        return None

    def _filled(self, word: str, folder: Path) -> str:
        """Fill the places of a word in."""
        places = {FOLDER: folder, RECIPES: self.recipes, HERE: Path.cwd(), PYTHON: sys.executable}
        return MARK.sub(lambda match: str(places[match[0]]), word)


def words_of(name: str, value: object) -> tuple[str, ...]:
    """Return the words of a command; ValueError for no list of strings or an unknown place."""
    if not isinstance(value, list | tuple) or not all(isinstance(word, str) for word in value):
        raise ValueError(f"{name} must be a list of strings, got {value!r}")
    for word in value:
        for mark in MARK.findall(word):
            if mark not in PLACES:
                raise ValueError(f"{name} has {mark} in {word!r}; allowed: {', '.join(PLACES)}")
    return tuple(value)


def environment(venv: str | None) -> dict[str, str]:
    """Return this process's variables without what would lead a program to its packages."""
    variables = {name: value for name, value in os.environ.items() if name not in HIDDEN}
    if venv is not None:
        folder = Path(venv).resolve()
        variables["VIRTUAL_ENV"] = str(folder)
        variables["PATH"] = f"{folder / 'bin'}{os.pathsep}{variables.get('PATH', os.defpath)}"
    return variables


@contextmanager
def running(
    command: Sequence[str], folder: Path, variables: Mapping[str, str]
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command in a folder, in its own process group, its output in log.txt; its processes
    are killed at the end of the block."""
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
            yield process
        finally:
            kill(process.pid)  # with whatever it started and left
            process.wait()


def run(command: Sequence[str], folder: Path, variables: Mapping[str, str], timeout: float) -> None:
    """Run a command to its end, see `running`; `Unfinished` for a timeout in seconds, full memory,
    or another exit code than zero."""
    with running(command, folder, variables) as process:
        try:
            code = process.wait(timeout)
        except subprocess.TimeoutExpired:
            code = None
    if code is None:
        raise Unfinished(TIMEOUT, f"{command[0]} was stopped at its time limit", tail(folder))
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
    """Return the outcome of an exit code, or of a signal below zero, and a sentence on it."""
    if FULL.search(log):
        return MEMORY, f"{program} ended with exit code {code}, out of memory"
    if code == -signal.SIGKILL:
        return MEMORY, f"{program} was killed, as the system does when memory runs out"
    return FAILED, f"{program} ended with exit code {code}"


def kill(group: int) -> None:
    """End the processes of a group."""
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return
