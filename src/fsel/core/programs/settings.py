"""Settings of a program that is run: its commands, its environment, and what it needs."""

from __future__ import annotations

import os
import re
import shutil
import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from fsel.core.programs.command import environment, run
from fsel.core.programs.outcome import NoDevice

FOLDER, RECIPES, HERE, PYTHON = "{folder}", "{recipes}", "{here}", "{python}"
PLACES = (FOLDER, RECIPES, HERE, PYTHON)
MARK = re.compile(r"\{[a-z_]+\}")


@dataclass(frozen=True)
class Program(ABC):
    """A program of one's own; a subclass adds its commands.

    The commands are run as they are, without a shell, with the rights of whoever runs the workflow:
    a configuration is trusted as a script is. In their words `{folder}` stands for the folder that
    they run in, `{recipes}` for the scripts that come with this library, `{here}` for this
    process's folder, `{python}` for its interpreter.

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

    recipes: ClassVar[Path]  # folder of the scripts that `{recipes}` stands for

    def __post_init__(self) -> None:
        object.__setattr__(self, "prefix", words_of("prefix", self.prefix))
        if isinstance(self.timeout, bool) or not 0 < self.timeout < float("inf"):
            raise ValueError(f"timeout must be seconds above zero, got {self.timeout!r}")
        if not isinstance(self.gpu, bool):
            raise ValueError(f"gpu must be true or false, got {self.gpu!r}")
        check_folder("venv", self.venv)
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
        """Run one of the commands in a folder to its end; its output goes to log.txt.

        Raises:
            Unfinished: when it fails; the end of its log is in the message.
        """
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
            found.append(NoDevice("gpu is true, and no driver of NVIDIA is here (nvidia-smi)"))
        return found

    def _absent(self) -> str | None:
        """The first command whose first word is no program, in words; None if all are there."""
        path = environment(self.venv).get("PATH", os.defpath)
        for words in self.commands:
            program = self.command(words, Path())[0]
            if os.path.dirname(program) and not os.path.isabs(program):
                return f"no program {program!r} where it runs. Hint: {HERE}/{program}"
            if shutil.which(program, path=path) is None:
                return f"no program {program!r} in {path}"
        return None

    def _filled(self, word: str, folder: Path) -> str:
        """A word with the places filled in."""
        places = {FOLDER: folder, RECIPES: self.recipes, HERE: Path.cwd(), PYTHON: sys.executable}
        return MARK.sub(lambda match: str(places[match[0]]), word)


def check_folder(name: str, value: object) -> None:
    """Refuse a folder that is neither text nor null."""
    if value is not None and not isinstance(value, str):
        raise ValueError(f"{name} must be a folder or null, got {value!r}")


def words_of(name: str, value: object) -> tuple[str, ...]:
    """The words of a command, checked.

    Raises:
        ValueError: for what is no list of strings, or has a place that is not known.
    """
    if not isinstance(value, list | tuple) or not all(isinstance(word, str) for word in value):
        raise ValueError(f"{name} must be a list of strings, got {value!r}")
    for word in value:
        for mark in MARK.findall(word):
            if mark not in PLACES:
                raise ValueError(f"{name} has {mark} in {word!r}; allowed: {', '.join(PLACES)}")
    return tuple(value)
