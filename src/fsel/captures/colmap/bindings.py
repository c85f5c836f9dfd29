"""Import of pycolmap without the signal handlers that its log installs.

They would print a C++ stack at the signal TERM. Everything imports pycolmap from here. Outside the
main thread, where Python sets no handlers, pycolmap's stay.
"""

from __future__ import annotations

import signal
import threading

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_main = threading.current_thread() is threading.main_thread()
_handlers = {number: signal.getsignal(number) for number in _SIGNALS if _main}
_masked = getattr(signal, "pthread_sigmask", None)  # Windows has none
_mask = _masked and _masked(signal.SIG_BLOCK, _SIGNALS)  # they wait meanwhile
try:
    import pycolmap
finally:
    for _number, _handler in _handlers.items():
        if _handler is not None:  # else it is none of Python's
            signal.signal(_number, _handler)
    if _masked:
        _masked(signal.SIG_SETMASK, _mask)

__all__ = ["pycolmap"]
