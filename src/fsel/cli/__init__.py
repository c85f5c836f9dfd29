"""The command line.

Exit codes: 0 done; 1 refused, with one line that says why; 2 a command line that is not
understood; 130 interrupted (143 where the signal was TERM). Whatever the code, what was to be
written is there whole or not at all.

This file imports little: before the handlers of signals are set, Ctrl-C prints a traceback.
"""

from __future__ import annotations

import errno
import os
import re
import signal
import sys
from contextlib import contextmanager
from importlib import import_module

TYPE_CHECKING = False  # what `typing` has, without importing it
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterator, Sequence
    from types import FrameType

REFUSED = 1
FULL = (errno.ENOSPC, errno.EDQUOT)
ARGUMENT = re.compile(r"`(\w+)=(\w+)`")  # of Python, in messages of the library
SAID, LATE = "fsel: interrupted, nothing was written", "fsel: interrupted, after all was written"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    with Interruption() as interruption:  # before anything that takes long to import
        from fsel.cli.parser import parsed

        args = parsed(arguments)
        # before NumPy is imported: on a selection's small matrices several threads only wait for
        # one another
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        with stderr_filter():
            return _run(args, interruption)


def _run(args: Namespace, interruption: Interruption) -> int:
    try:
        command = import_module(f"fsel.cli.{args.command}")
        from fsel.cli.console import Compiling, Console
        from fsel.core.limits import WHEN_COMPILED, set_threads

        if getattr(args, "threads", None):
            set_threads(args.threads)
        interruption.working = True
        console = Console(args.quiet, args.json)
        WHEN_COMPILED[:] = [Compiling(console)]
        command.run(args, console)
        interruption.working, interruption.said = False, LATE
    except BaseException as error:
        interruption.working = False
        if interruption.number or isinstance(error, KeyboardInterrupt):
            print(SAID, file=sys.stderr)
            return 128 + (interruption.number or signal.SIGINT)
        if not isinstance(error, ValueError | OSError | MemoryError | ImportError):
            raise
        print(f"fsel: {_in_words(error, args)}", file=sys.stderr)
        return REFUSED
    if interruption.number:  # a library lost it
        print(LATE, file=sys.stderr)
        return 128 + interruption.number
    return 0


def _in_words(error: Exception, args: Namespace) -> str:
    """Return one line that names a file."""
    from fsel.cli.console import STANDARD_OUTPUT
    from fsel.core.files import cache

    read = getattr(args, "capture", None) or getattr(args, "out", None)
    if isinstance(error, OSError) and error.strerror:
        named = error.filename or getattr(args, "out", None) or read
        full = str(error.filename2 or named)  # where a copy is written to
        if error.errno in FULL and not full.startswith((STANDARD_OUTPUT, str(cache()))):
            named = getattr(args, "out", None) or named
        return f"{named}: {error.strerror}"
    if isinstance(error, MemoryError):
        return f"{read}: does not fit in memory"
    if type(error).__name__ == "LinAlgError":  # NumPy's, which names no file
        return f"{read}: the cameras' poses are degenerate ({error})"
    return with_options(" ".join(str(error).split("\n")))


def with_options(message: str) -> str:
    """Return a message of the library with options of the command for arguments of Python."""

    def option(argument: re.Match) -> str:
        value = "" if argument[2] == "True" else f" {argument[2]}"
        return f"--{argument[1].replace('_', '-')}{value}"

    return ARGUMENT.sub(option, message)


class Interruption:
    """Ctrl-C and the signal TERM, handled within the block.

    While libraries are imported, before there is anything to clear up, a signal ends the process at
    once: raised amid an import, it would come out as another error or be lost in C++.
    """

    def __init__(self) -> None:
        self.number = 0  # of the signal
        self.working = False  # whether there is anything to clear up
        self.said = SAID

    def __enter__(self) -> Interruption:
        signals = (signal.SIGINT, signal.SIGTERM)
        handled = [n for n in signals if signal.getsignal(n) != signal.SIG_IGN]
        self._previous = {n: signal.signal(n, self.receive) for n in handled}
        return self

    def __exit__(self, *raised: object) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def receive(self, number: int, frame: FrameType | None) -> None:
        """Handle either signal."""
        self.number = number
        if self.working:
            raise KeyboardInterrupt
        print(self.said, file=sys.stderr, flush=True)
        os._exit(128 + number)


@contextmanager
def stderr_filter() -> Iterator[None]:
    """Drop lines that C libraries print on standard error; Python's are printed."""
    own = sys.stderr
    try:
        shown = own.fileno() == 2
    except (OSError, ValueError, AttributeError):
        shown = False
    if not shown:  # replaced by whoever called the command from Python
        yield
        return
    own.flush()
    kept = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)
    with open(kept, "w", buffering=1, encoding=own.encoding, errors=own.errors) as stream:
        sys.stderr = stream
        try:
            yield
        finally:
            stream.flush()
            os.dup2(kept, 2)
            sys.stderr = own
