"""`--refine`: swaps with a bar and the time left; Ctrl-C keeps the best so far."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from fsel.cli.console import Console
from fsel.cli.optimising import stopped_by_interrupt
from fsel.request.refine import Refine, Swapped

KEPT = "interrupted: the best picks so far are written; again to give up"


@contextmanager
def refining(refine: Refine | None, console: Console) -> Iterator[Refine | None]:
    """Argument `refine` of `fsel.select`; None without `--refine`."""
    if refine is None:
        yield None
        return
    with (
        console.seconds("refining", refine.seconds) as show,
        stopped_by_interrupt(console, KEPT) as stop,
    ):

        def progress(best: Swapped, gone: float) -> bool:
            show(gone, f"{best.gain:+.2f} dB")
            return not stop()

        yield replace(refine, progress=progress)
