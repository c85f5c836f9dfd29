"""The command line.

Exit codes: 0 done; 1 refused, with one line that says why; 2 a command line that is not
understood; 130 interrupted (143 where the signal was TERM). Whatever the code, what was to be
written is there whole or not at all.
"""

from __future__ import annotations

import errno
import os
import sys
from importlib import import_module

from fsel.cli.signals import SAID, Interruption

TYPE_CHECKING = False  # see `fsel.cli.signals`
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence

REFUSED = 1
INTERRUPTED = 130
FULL = (errno.ENOSPC, errno.EDQUOT)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    with Interruption() as interruption:  # before anything that takes long to import
        from fsel.cli.parser import parsed
        from fsel.cli.silence import native_lines_dropped

        args = parsed(arguments)
        # before NumPy is imported: on a selection's small matrices several threads only wait for
        # one another
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        with native_lines_dropped():
            return _run(args, interruption)


def _run(args: Namespace, interruption: Interruption) -> int:
    try:
        command = import_module(f"fsel.cli.{args.command}")
        from fsel.cli.console import Console

        interruption.working = True
        command.run(args, Console(args.quiet, args.json))
    except BaseException as error:
        interruption.working = False
        if interruption.number or isinstance(error, KeyboardInterrupt):
            print(SAID, file=sys.stderr)
            return 128 + interruption.number if interruption.number else INTERRUPTED
        if not isinstance(error, ValueError | OSError | MemoryError | ImportError):
            raise
        print(f"fsel: {_in_words(error, args)}", file=sys.stderr)
        return REFUSED
    return 0


def _in_words(error: Exception, args: Namespace) -> str:
    """One line that names a file."""
    if isinstance(error, OSError) and error.strerror:
        named = error.filename or getattr(args, "out", None) or args.capture
        if error.errno in FULL:  # a copy's error has the name of what was read
            named = getattr(args, "out", None) or named
        return f"{named}: {error.strerror}"
    if isinstance(error, MemoryError):
        return f"{_read(args)}: takes more memory than there is"
    if type(error).__name__ == "LinAlgError":  # NumPy's, which names no file
        return f"{_read(args)}: its cameras' poses leave the computation no answer ({error})"
    return " ".join(str(error).split("\n"))


def _read(args: Namespace) -> object:
    """Path that a command reads, or writes where it reads nothing."""
    return getattr(args, "capture", None) or args.out
