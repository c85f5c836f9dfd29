"""pycolmap without the signal handlers that its log installs when it is imported.

They would print a C++ stack at the signal TERM. Everything imports pycolmap from here. Outside the
main thread, where Python sets no handlers, pycolmap's stay.
"""

from __future__ import annotations

import signal
import threading

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_main = threading.current_thread() is threading.main_thread()
_handlers = {number: signal.getsignal(number) for number in _SIGNALS if _main}
_mask = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)  # they wait meanwhile
try:
    import pycolmap
finally:
    for _number, _handler in _handlers.items():
        if _handler is not None:  # else it is none of Python's
            signal.signal(_number, _handler)
    signal.pthread_sigmask(signal.SIG_SETMASK, _mask)

__all__ = ["pycolmap"]
