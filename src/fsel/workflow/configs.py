"""Config files that Snakemake is given, read before Snakemake reads them.

Of a file that is no YAML, Snakemake tells neither the name nor the line, and it loads what
`--configfile` names before any rule. Profiles are read earlier still: those of `profiles` call
`refuse_broken`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import yaml

DEFAULT = "config/config.yaml"  # what the Snakefile loads where none is named


def refuse_broken(line: Sequence[str] | None = None) -> None:
    """End the process, in words, when a config file of Snakemake's command line is broken.

    Args:
        line: the command line; that of this process by default.

    Raises:
        SystemExit: naming the file, and the line and the column of its fault.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", default=[DEFAULT])
    asked, _ = parser.parse_known_args(sys.argv[1:] if line is None else line)
    for name in asked.configfile:
        fault = fault_of(Path(name))
        if fault:
            raise SystemExit(f"{name}{fault}")


def fault_of(path: Path) -> str | None:
    """Where a config file is broken and how; None where it is not, or is not there."""
    if not path.is_file():
        return None
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        return f": not a text in UTF-8 (byte {error.start})"
    try:
        content = json.loads(text)
    except ValueError:  # as Snakemake does: JSON may hold tabs, which YAML refuses
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError as error:
            return _in_words(error)
    if not isinstance(content, dict):
        return ": holds no keys at its top level"
    return None


def _in_words(error: yaml.YAMLError) -> str:
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return f": not readable as YAML ({' '.join(str(error).split())})"
    mark = error.problem_mark
    context = f"{error.context}: " if error.context else ""
    return f", line {mark.line + 1}, column {mark.column + 1}: {context}{error.problem}"
