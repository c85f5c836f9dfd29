"""`--patience`: trying selections with a bar and the time left; Ctrl-C ends it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from fsel.cli.console import Console
from fsel.cli.optimising import stopped_by_interrupt
from fsel.request.patience import Patience

KEPT = "interrupted: what was tried so far decides; again to give up"


@contextmanager
def trying(patience: Patience, console: Console) -> Iterator[Patience]:
    """Argument `patience` of `fsel.select`, with its progress shown."""
    if not patience.seconds:
        yield patience
        return
    with (
        console.seconds("trying", patience.seconds) as show,
        stopped_by_interrupt(console, KEPT) as stop,
    ):

        def progress(made: int, planned: int, gone: float) -> bool:
            show(gone, f"{made} of {planned} fits")
            return not stop()

        yield Patience(patience.seconds, progress)
