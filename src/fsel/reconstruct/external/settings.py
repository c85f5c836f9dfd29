"""Settings of the reconstructor `external`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from fsel.core.programs.settings import Program, check_folder, words_of


@dataclass(frozen=True)
class ExternalSettings(Program):
    """A program of one's own that reconstructs and renders.

    Its folder is the one that `fsel.reconstruct.external.folder` describes.

    Attributes:
        serve: the command of a worker, a list of strings: a program that is started once a job and
            answers requests, as docs/reconstructors.md describes; in the place of `render` and
            `fit`, which are run for every subset.
        render: the command that renders the targets, a list of strings.
        fit: the command that reconstructs, run before; null where one command does both.
        memory: bytes; a worker that holds more resident memory after a fit is started anew before
            the next one. Null for none.
        workspace: folder in which the folders are made and kept; null for temporary ones.
    """

    serve: tuple[str, ...] = ()
    render: tuple[str, ...] = ()
    fit: tuple[str, ...] | None = None
    memory: int | None = None
    workspace: str | None = None

    recipes: ClassVar = Path(__file__).parent / "recipes"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("serve", "render", "fit"):
            if (value := getattr(self, name)) is not None or name != "fit":
                object.__setattr__(self, name, words_of(name, value))
        if self.serve and (self.render or self.fit is not None):
            raise ValueError(
                "serve is given, and render or fit too; allowed: a worker, or commands"
            )
        if not self.serve and not self.render:
            raise ValueError("render must be a command, a list of strings, got none; or serve")
        if self.fit == ():
            raise ValueError("fit must be a command or null, got an empty list")
        if self.memory is not None and (type(self.memory) is not int or self.memory < 1):
            raise ValueError(f"memory must be bytes above zero or null, got {self.memory!r}")
        check_folder("workspace", self.workspace)

    @property
    def commands(self) -> Sequence[tuple[str, ...]]:
        """Words of the commands that are given."""
        return [words for words in (self.serve, self.fit, self.render) if words]

    def missing(self) -> list[Exception]:
        """List what it needs and is not here, a workspace too."""
        found = super().missing()
        if self.workspace is not None and not Path(self.workspace).is_dir():
            found.append(FileNotFoundError(f"workspace: no folder {self.workspace}"))
        return found
