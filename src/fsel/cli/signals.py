"""Handling of Ctrl-C and the signal TERM, from the start of a command on.

Imports as little as it can: before the handlers are set, Ctrl-C prints a traceback.
"""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # what `typing` has, without importing it
if TYPE_CHECKING:
    from types import FrameType, TracebackType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SAID = "fsel: interrupted, nothing was written"


class Interruption:
    """Signal that was received; within the block both signals are handled.

    What ran before takes its handlers back at the end.

    Attributes:
        number: of the signal; 0 while there is none.
        working: whether there is anything to clear up. Before, while libraries are imported, a
            signal ends the process at once: raised amid an import, it would come out as another
            error or be lost in C++.
    """

    def __init__(self) -> None:
        self.number = 0
        self.working = False

    def __enter__(self) -> Interruption:
        handled = [n for n in SIGNALS if signal.getsignal(n) != signal.SIG_IGN]
        self._previous = {n: signal.signal(n, self.receive) for n in handled}
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def receive(self, number: int, frame: FrameType | None) -> None:
        """The handler of both signals."""
        self.number = number
        if self.working:
            raise KeyboardInterrupt
        print(SAID, file=sys.stderr, flush=True)
        os._exit(128 + number)
