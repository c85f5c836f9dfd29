"""Poses by another program: it is given a folder of images, and writes a COLMAP model of them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsel.core.files import emptied
from fsel.core.programs import MissingRequirement, NoDevice, Program, Unfinished, tail, words_of
from fsel.core.registry import settings_from

MODELS = "sparse"
OWN = "COLMAP"  # what places frames where no program is named
SCRIPTS = (".py", ".sh")


@dataclass(frozen=True)
class Estimator(Program):
    """A program, or several one after the other, that find the poses of images.

    In their folder are the `images`, without folders among them, and an empty folder `sparse`, into
    which a COLMAP model is written, binary or text, or several into folders of it. Its images are
    named as in `images`.

    Attributes:
        by: a command, a list of strings; or a list of such.
    """

    by: tuple[tuple[str, ...], ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        listed = isinstance(self.by, list | tuple)
        several = listed and any(isinstance(part, list | tuple) for part in self.by)
        parts = self.by if several else [self.by]
        object.__setattr__(self, "by", tuple(words_of("by", part) for part in parts))
        if not all(self.by):
            raise ValueError("by must be a list of strings, or a list of such, got none")

    @property
    def commands(self) -> Sequence[tuple[str, ...]]:
        """Words of the commands, in order."""
        return self.by

    @property
    def name(self) -> str:
        """Name for tables and messages: that of the script, or else of the last program."""
        scripts = [word for words in self.by for word in words if word.endswith(SCRIPTS)]
        return Path(scripts[-1]).stem if scripts else Path(self.by[-1][0]).name

    def models(self, folder: Path) -> list[Path]:
        """Run it in a folder and return those of the models that it wrote, at least one."""
        output = folder / MODELS
        self.write(folder, output, "poses")
        files = [*output.rglob("images.bin"), *output.rglob("images.txt")]
        if not files:
            raise ValueError(
                f"poses by {self.name}: it wrote no COLMAP model (images.bin or images.txt) into "
                f"{MODELS}\n{tail(folder)}"
            )
        return sorted({path.parent for path in files})

    def write(self, folder: Path, output: Path, what: str) -> None:
        """Run it in a folder, to write what it makes into another that is empty."""
        emptied(output)
        try:
            for words in self.by:
                self.run(words, folder)
        except Unfinished as error:
            raise ValueError(f"{what} by {self.name}: {error}") from error


def named(features: str) -> str:
    """Return the name of COLMAP with features."""
    return OWN if features == "sift" else f"{OWN} with {features}"


def source_of(poses: str | Mapping[str, Any], model: str) -> str:
    """Return the name of a source of poses for tables: `poses` and `model` of a configuration."""
    if isinstance(poses, str):
        return {"layout": "as distributed", "colmap": OWN, "file": model}[poses]
    if "features" in poses:
        return named(poses["features"])
    return settings_from(Estimator, poses).name


def checked(poses: Mapping[str, Any], devices: bool = True) -> Estimator:
    """Return the program of a configuration's `poses`.

    Args:
        poses: fields of `Estimator`.
        devices: whether a GPU must be here; on a cluster it is where the jobs run.

    Raises:
        MissingRequirement: for what it needs and is not here, all of it by name.
    """
    try:
        estimator = settings_from(Estimator, poses)
    except (ValueError, TypeError) as error:
        raise ValueError(f"poses: {error}") from error
    lacking = [e for e in estimator.missing() if devices or not isinstance(e, NoDevice)]
    if lacking:
        said = "\n".join(map(str, lacking))
        raise MissingRequirement(f"poses by {estimator.name}: {said}") from lacking[0]
    return estimator


def program(commands: tuple[str, ...], option: str) -> Estimator | None:
    """The program that `--by` or `--mask-by` names, which must be here; None without commands."""
    if not commands:
        return None
    try:
        words = [shlex.split(line) for line in commands]
    except ValueError as error:
        raise ValueError(f"--{option} {' '.join(commands)}: {error}") from error
    return checked({"by": words})
