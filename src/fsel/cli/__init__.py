"""The command line.

Exit codes: 0 done; 1 refused, with one line that says why; 2 a command line that is not
understood; 130 interrupted (143 where the signal was TERM). Whatever the code, what was to be
written is there whole or not at all.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType

from fsel.cli.parser import parser

REFUSED = 1


class _Terminated(KeyboardInterrupt):
    pass


def _terminate(number: int, frame: FrameType | None) -> None:
    raise _Terminated


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    asked = parser().parse_args(arguments)
    # before NumPy is imported: on a selection's small matrices more threads only wait for another
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from fsel.cli.console import Console

    console = Console(asked.quiet, asked.json)
    previous = signal.signal(signal.SIGTERM, _terminate)
    try:
        asked.command(asked, console)
    except (ValueError, OSError) as error:
        print(f"fsel: {_in_words(error)}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt as error:
        print("fsel: interrupted, nothing was written", file=sys.stderr)
        number = signal.SIGTERM if isinstance(error, _Terminated) else signal.SIGINT
        return 128 + number
    finally:
        signal.signal(signal.SIGTERM, previous)
    return 0


def _in_words(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
