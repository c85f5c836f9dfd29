"""Standard error without the lines that image libraries print there by themselves."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def native_lines_dropped() -> Iterator[None]:
    """Lines of C libraries are dropped, Python's are printed; errors say what matters."""
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
