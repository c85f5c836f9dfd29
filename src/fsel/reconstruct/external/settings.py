"""Settings of the reconstructor `external`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

FOLDER, RECIPES, HERE = "{folder}", "{recipes}", "{here}"
PLACES = (FOLDER, RECIPES, HERE)
MARK = re.compile(r"\{[a-z_]+\}")


@dataclass(frozen=True)
class ExternalSettings:
    """A program of one's own that reconstructs and renders.

    The commands are run as they are, without a shell, with the rights of whoever runs the workflow:
    a configuration is trusted as a script is.

    Attributes:
        serve: the command of a worker, a list of strings: a program that is started once a job and
            answers requests, as docs/reconstructors.md describes; in the place of `render` and
            `fit`, which are run for every subset.
        render: the command that renders the targets, a list of strings. `{folder}` stands for the
            folder that `fsel.reconstruct.external.folder` describes, in which it runs; `{recipes}`
            for the scripts that come with this library; `{here}` for this process's folder.
        fit: the command that reconstructs, run before; null where one command does both.
        venv: folder of a virtual environment whose programs come first; null for none.
        prefix: words before each command, such as `[conda, run, -n, nerf]`, `[apptainer, exec,
            --nv, image.sif]` or `[env, CUDA_VISIBLE_DEVICES=0]`.
        timeout: seconds that each command, or answer of a worker, may take.
        memory: bytes; a worker that holds more resident memory after a fit is started anew before
            the next one. Null for none.
        gpu: whether it works on a GPU, whose memory is measured then.
        workspace: folder in which the folders are made and kept; null for temporary ones.
        files: path -> how to get it, of each file or folder that must be there before a run;
            `{here}` as in the commands.
    """

    serve: tuple[str, ...] = ()
    render: tuple[str, ...] = ()
    fit: tuple[str, ...] | None = None
    venv: str | None = None
    prefix: tuple[str, ...] = ()
    timeout: float = 7200.0
    memory: int | None = None
    gpu: bool = False
    workspace: str | None = None
    files: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("serve", "render", "fit", "prefix"):
            object.__setattr__(self, name, _words(name, getattr(self, name)))
        if self.serve and (self.render or self.fit is not None):
            raise ValueError(
                "serve is given, and render or fit too; allowed: a worker, or commands"
            )
        if not self.serve and not self.render:
            raise ValueError("render must be a command, a list of strings, got none; or serve")
        if self.fit == ():
            raise ValueError("fit must be a command or null, got an empty list")
        if isinstance(self.timeout, bool) or not 0 < self.timeout < float("inf"):
            raise ValueError(f"timeout must be seconds above zero, got {self.timeout!r}")
        if self.memory is not None and (type(self.memory) is not int or self.memory < 1):
            raise ValueError(f"memory must be bytes above zero or null, got {self.memory!r}")
        if not isinstance(self.gpu, bool):
            raise ValueError(f"gpu must be true or false, got {self.gpu!r}")
        for name in ("venv", "workspace"):
            value = getattr(self, name)
            if value is not None and not isinstance(value, str):
                raise ValueError(f"{name} must be a folder or null, got {value!r}")
        if not isinstance(self.files, Mapping) or not all(
            isinstance(word, str) for pair in self.files.items() for word in pair
        ):
            raise ValueError(f"files must map paths to words, got {self.files!r}")
        _words("files", list(self.files))

    def command(self, words: tuple[str, ...], folder: Path) -> list[str]:
        """Return the command to run: the prefix, and the words with the places filled in."""
        return [*self.prefix, *(_filled(word, folder) for word in words)]

    def missing(self) -> list[str]:
        """Describe each of `files` that is not there."""
        return [
            f"{path.replace(HERE, '.')} is missing: {how}"
            for path, how in self.files.items()
            if not Path(_filled(path, Path())).exists()
        ]


def _filled(word: str, folder: Path) -> str:
    """A word with the places filled in."""
    places = {FOLDER: folder, RECIPES: Path(__file__).parent / "recipes", HERE: Path.cwd()}
    return MARK.sub(lambda match: str(places[match[0]]), word)


def _words(name: str, value) -> tuple[str, ...] | None:
    if value is None and name == "fit":
        return None
    if not isinstance(value, list | tuple) or not all(isinstance(word, str) for word in value):
        raise ValueError(f"{name} must be a list of strings, got {value!r}")
    for word in value:
        for mark in MARK.findall(word):
            if mark not in PLACES:
                raise ValueError(f"{name} has {mark} in {word!r}; allowed: {', '.join(PLACES)}")
    return tuple(value)
