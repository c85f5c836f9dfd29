"""The environment that jobs start in: what they inherit, and the image of a container."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from fsel.workflow import processor
from fsel.workflow.refusal import Refusal, refuse

FOLDER = Path(__file__).resolve().parents[3]  # of the checkout that holds the workflow
IMAGE = FOLDER / "workflow" / "envs" / "fsel.sif"
SHELL = re.compile(r"[\s\"'`$&();<>|*?\\]")  # what a shell does not take as it is
KEPT = 32 << 20  # bytes

INHERITED = {
    # every evaluation makes and drops arrays of megabytes: glibc would hand their pages back to the
    # kernel each time and ask for them anew, 8 % of a search
    "MALLOC_MMAP_THRESHOLD_": str(KEPT),
    "MALLOC_TRIM_THRESHOLD_": str(KEPT),
}


def prepare(tell: bool = False) -> None:
    """Set what every job inherits, unless it is set already.

    Args:
        tell: print which variables are set to what gives results other bytes.

    Raises:
        Refusal: when Snakemake could not start a job by the path of this Python.
    """
    if found := SHELL.search(sys.executable):
        refuse(
            f"Snakemake starts no job by {sys.executable}: it does not quote {found[0]!r}",
            "make the virtual environment, or the clone, where no folder's name has it",
        )
    # the same instructions on every processor, so the same bytes
    pinned = processor.environment()
    for name, value in {**INHERITED, **pinned}.items():
        os.environ.setdefault(name, value)
    for name, value in pinned.items() if tell else ():
        if os.environ[name] != value:
            print(
                f"{name} is set to {os.environ[name]!r}, not {value!r}: the last digits of results "
                f"may differ from those of other machines. Hint: unset {name}",
                file=sys.stderr,
            )
    # images of containers often set it: every job would compile pandas anew, a second each
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def check_image() -> None:
    """Refuse `--software-deployment-method apptainer` without the image that jobs would run in.

    Raises:
        Refusal: when it is not there.
    """
    if not IMAGE.exists():
        raise Refusal(
            f"no {IMAGE}, the image for --software-deployment-method apptainer\n"
            f"Hint: apptainer build {IMAGE} {IMAGE.with_suffix('.def')}"
        )
    # the image holds what the library needs; the library is this one
    os.environ.update(PYTHONPATH=str(FOLDER / "src"))
