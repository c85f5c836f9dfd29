"""A rule as a job: the function of its name, its arguments, its log, its threads."""

from __future__ import annotations

import gc
import inspect
import logging
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2

from fsel.core.files import digest
from fsel.core.limits import set_threads
from fsel.workflow.functions import function_of

CAPTURE = ("frames", "points", "images", "masks", "descriptors")  # files of a canonical capture
LIBRARY = "lib"  # the param with the digest of the sources of a rule's function
NO_ARGUMENTS = (LIBRARY, "programs")  # the latter is an input that refuses what is not here

logger = logging.getLogger("fsel")


def run(snakemake: Any) -> None:
    """Call the function of a rule as a job, logged to `snakemake.log[0]`, within its threads; TERM,
    by which a cluster ends jobs, is an exception, so that unfinished files are removed."""
    handler = logging.FileHandler(snakemake.log[0], mode="w")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    root = logging.getLogger()
    root.addHandler(handler)
    root.setLevel(logging.INFO)
    logging.captureWarnings(True)
    cv2.setNumThreads(snakemake.threads)
    set_threads(snakemake.threads)
    previous = signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    try:
        gc.disable()  # little that is made while importing is garbage
        function = function_of(snakemake.rule)
        gc.freeze()
        gc.enable()
        function(**arguments(snakemake, function))
    except BaseException:
        logger.exception("failed")
        raise
    finally:
        signal.signal(signal.SIGTERM, previous)
        root.removeHandler(handler)
        handler.close()


def arguments(snakemake: Any, function: Callable[..., None]) -> dict[str, object]:
    """Collect what a rule has for each parameter of a function, as it is: nothing is converted.

    A parameter is the input, output or param of its name. Otherwise it is

    - `folder`: the folder of the rule's `frames`, `points`, `images`, `masks` and `descriptors`,
      files of one canonical capture; `folders` of several captures, one folder each; `x_folder`
      and `x_folders` of `x_frames` and so on;
    - `inputs`: every input file; `threads`; `config`: the digest of the params, for its tables;
      `library`: the param `lib`, the digest of the sources that the rule depends on, which is in
      no other digest;
    - a wildcard.

    Raises:
        TypeError: for a parameter without a value, and for an input, output or param that no
            parameter takes.
    """
    where = f"rule {snakemake.rule}, function {function.__qualname__}"
    parts = (snakemake.input, snakemake.output, snakemake.params)
    given = {name: value for part in parts for name, value in part.items()}
    given = {name: value for name, value in given.items() if name not in NO_ARGUMENTS}
    folders = _folders(snakemake, where)
    further = {
        **dict(snakemake.wildcards.items()),
        "inputs": list(snakemake.input),
        "threads": snakemake.threads,
        "library": snakemake.params.get(LIBRARY, ""),
        "config": digest({k: v for k, v in snakemake.params.items() if k != LIBRARY}),
    }
    taken, left = {}, set(given)
    parameters = inspect.signature(function).parameters
    for name, parameter in parameters.items():
        if name in given:
            taken[name] = given[name]
            left.discard(name)
        elif name in folders:
            taken[name], files = folders[name]
            left -= files
        elif name in further:
            taken[name] = further[name]
        elif parameter.default is inspect.Parameter.empty:
            raise TypeError(
                f"{where}: parameter {name!r} has no value; the rule names {sorted(given)}, "
                f"folders {sorted(folders)} and wildcards {sorted(snakemake.wildcards.keys())}"
            )
    if left:
        raise TypeError(
            f"{where}: {sorted(left)} of the rule are no parameters; those are {list(parameters)}"
        )
    return taken


def _folders(snakemake: Any, where: str) -> dict[str, tuple[object, set[str]]]:
    """Map a parameter to the folder, or folders, of captures, and the names of their files."""
    folders: dict[str, tuple[object, set[str]]] = {}
    for name, value in [*snakemake.input.items(), *snakemake.output.items()]:
        prefix, _, file = name.rpartition("_")
        if file not in CAPTURE:
            continue
        several = isinstance(value, list | tuple)
        folder = [str(Path(p).parent) for p in value] if several else str(Path(value).parent)
        key = f"{prefix}_folder".lstrip("_") + "s" * several
        known, files = folders.get(key, (folder, set()))
        if known != folder:
            raise TypeError(f"{where}: {name!r} lies in {folder}, {sorted(files)} in {known}")
        folders[key] = folder, files | {name}
    return folders
