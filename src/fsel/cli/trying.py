"""`--patience`: selections are tried for seconds, with a bar; Ctrl-C keeps what is best."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from fsel.cli.console import Console
from fsel.cli.optimising import stopped_by_interrupt
from fsel.selection.validation import TimeBudget

TRIED = "interrupted: what was tried so far decides; again to give up"


@contextmanager
def trying(patience: TimeBudget, console: Console) -> Iterator[TimeBudget]:
    """Argument `patience` of `fsel.select`, with its progress shown."""
    if not patience.seconds:
        yield patience
        return
    shown = console.seconds("trying", patience.seconds)
    with shown as show, stopped_by_interrupt(console, TRIED) as stop:

        def progress(made: int, planned: int, gone: float) -> bool:
            show(gone, f"{made} of {planned} fits")
            return not stop()

        yield TimeBudget(patience.seconds, progress)
