"""What Ctrl-C and the signal TERM do, from a command's first moment on."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SAID = "fsel: interrupted, nothing was written"


class Interruption:
    """What was received.

    Attributes:
        number: of the signal; 0 while there is none.
        working: whether there is anything to clear up. Before, while libraries are imported, a
            signal ends the process at once: raised amid an import, it would come out as another
            error or be lost in C++.
    """

    def __init__(self) -> None:
        self.number = 0
        self.working = False

    def receive(self, number: int, frame: FrameType | None) -> None:
        """The handler of both signals."""
        self.number = number
        if self.working:
            raise KeyboardInterrupt
        print(SAID, file=sys.stderr, flush=True)
        os._exit(128 + number)


@contextmanager
def watched() -> Iterator[Interruption]:
    """Both signals are handled; what ran before takes its handlers back."""
    found = Interruption()
    ignored = {number for number in SIGNALS if signal.getsignal(number) == signal.SIG_IGN}
    previous = {n: signal.signal(n, found.receive) for n in SIGNALS if n not in ignored}
    try:
        yield found
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
