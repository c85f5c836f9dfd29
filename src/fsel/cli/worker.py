"""`fsel reconstruct --check-worker` and `--cost`: a program, or a recipe, before it is used."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.lazy import open_capture
from fsel.cli.console import Console
from fsel.cli.options import positive, whole
from fsel.core.capture import Capture
from fsel.core.programs.outcome import Unfinished
from fsel.core.wording import counted
from fsel.reconstruct import check_needs
from fsel.reconstruct.cost import FITS, measured_cost
from fsel.reconstruct.external.conformance import SIZE, Checks, ring
from fsel.reconstruct.external.settings import ExternalSettings


def parser() -> argparse.ArgumentParser:
    """The grammar of both."""
    command = argparse.ArgumentParser(
        prog="fsel reconstruct",
        description="Check that a program keeps the protocol of a worker; or measure the seconds "
        "that a reconstructor takes to load, to fit and to render.",
    )
    what = command.add_mutually_exclusive_group(required=True)
    what.add_argument("--check-worker", action="store_true", help="check the program")
    what.add_argument("--cost", action="store_true", help="measure the program, or a recipe")
    command.add_argument("--recipe", type=Path, help="file with `reconstruction`, to measure")
    command.add_argument(
        "--capture", type=Path, help="what to measure on; a small ring of cameras without it"
    )
    command.add_argument("-k", type=whole(2), default=20, help="frames of a subset, 20 by default")
    command.add_argument(
        "--views", type=whole(1), default=15, help="rendered from each, 15 by default"
    )
    command.add_argument("--long-side", type=whole(1), help="of the images, in pixels")
    command.add_argument("--venv", help="virtual environment whose programs come first")
    command.add_argument(
        "--timeout", type=positive, default=600.0, help="seconds of an answer, 600 by default"
    )
    command.add_argument("--gpu", action="store_true", help="it works on a GPU")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.add_argument("--json", action="store_true", help="print the result as JSON")
    command.add_argument("program", nargs="*", help="after two hyphens: the worker and its options")
    command.set_defaults(command="worker")
    return command


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry one of the two out."""
    if bool(args.program) == bool(args.recipe):
        raise ValueError("name a program after --, as in `-- python mine.py`, or give --recipe")
    if args.recipe and (args.venv or args.gpu):
        raise ValueError("--venv and --gpu go with a program; a recipe states its own")
    if args.check_worker and args.recipe:
        raise ValueError("--check-worker takes a program, not --recipe")
    for option, package in (("check_worker", "jsonschema"), ("recipe", "yaml")):
        if getattr(args, option) and find_spec(package) is None:
            name = option.replace("_", "-")
            raise ValueError(f"--{name} needs {package}. Hint: pip install 'fsel[workflow]'")
    if args.check_worker:
        _check(args, console)
    else:
        _cost(args, console)


def _settings(args: argparse.Namespace) -> dict[str, Any]:
    return {"serve": args.program, "venv": args.venv, "timeout": args.timeout, "gpu": args.gpu}


def _check(args: argparse.Namespace, console: Console) -> None:
    """Print every check; raise where one failed."""
    check_needs({"name": "external", "settings": _settings(args)})
    found = []
    for checked in Checks(ExternalSettings(**_settings(args))).run():
        found.append(checked)
        console.say("wrong" if checked.wrong else "ok", checked.title)
        for line in (checked.wrong or checked.note).splitlines():
            console.say("", line)
    console.give({"checks": [vars(checked) for checked in found]})
    if failed := [checked.title for checked in found if checked.wrong]:
        raise ValueError(f"{counted(len(failed), 'check')} failed: {', '.join(failed)}")


def _cost(args: argparse.Namespace, console: Console) -> None:
    """Print what a reconstructor costs, as a configuration states it."""
    sections = _sections(args)
    for section in sections:
        check_needs(section)
    least = args.k + args.views + FITS
    capture = _capture(args.capture, least, max(s["long_side"] for s in sections))
    costs = {}
    for section in sections:
        name = section.get("as", section["name"])
        try:
            cost = measured_cost(capture, section, args.k, args.views)
        except Unfinished as error:
            raise ValueError(f"{name}: {error.outcome}: {error}") from error
        costs[name] = cost.section | {"peak_bytes": cost.peak_bytes, "device": cost.device}
        stated = ", ".join(f"{key}: {value:g}" for key, value in cost.section.items())
        memory = f"{cost.peak_bytes / 1e6:.0f} MB of {cost.device}"
        console.say(name, f"cost: {{{stated}}}, {memory} at its highest")
    size = "x".join(map(str, capture.resized(sections[0]["long_side"]).size))
    console.say("measured", f"{args.k} frames and {args.views} views of {size}, {capture.source}")
    console.give({"cost": costs})


def _sections(args: argparse.Namespace) -> list[Mapping[str, Any]]:
    """The reconstructors to measure, as a configuration has them."""
    if args.program:
        long_side = args.long_side or SIZE[0]
        return [{"name": "external", "long_side": long_side, "settings": _settings(args)}]
    import yaml  # here: nothing else reads a configuration

    content = yaml.safe_load(args.recipe.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or "reconstruction" not in content:
        raise ValueError(f"{args.recipe}: has no `reconstruction`")
    given = content["reconstruction"]
    own = {"long_side": args.long_side} if args.long_side else {}
    defaults = {"long_side": SIZE[0], "settings": {}}
    return [{**defaults, **s, **own} for s in (given if isinstance(given, list) else [given])]


def _capture(path: Path | None, least: int, long_side: int) -> Capture:
    if path is None:
        return ring(least, (long_side, round(long_side * SIZE[1] / SIZE[0])))
    opened = open_capture(path, long_side=long_side)
    if len(opened.capture) < least:
        raise ValueError(f"{path}: has {len(opened.capture)} frames; {least} are needed")
    spread = np.linspace(0, len(opened.capture) - 1, least).astype(np.int64)
    return opened.loaded(spread)
