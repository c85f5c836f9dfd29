"""`--patience` and `--refine`: what is tried for seconds, with a bar; Ctrl-C keeps what is best."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from fsel.cli.console import Console
from fsel.cli.optimising import stopped_by_interrupt
from fsel.selection.patience import Patience
from fsel.selection.refine import Refine

TRIED = "interrupted: what was tried so far decides; again to give up"
REFINED = "interrupted: the best picks so far are written; again to give up"


@contextmanager
def _watched(
    console: Console, label: str, seconds: float, kept: str
) -> Iterator[Callable[[float, str], bool]]:
    """Function of the seconds gone and a word to show: whether to go on."""
    with console.seconds(label, seconds) as show, stopped_by_interrupt(console, kept) as stop:

        def going(gone: float, word: str) -> bool:
            show(gone, word)
            return not stop()

        yield going


@contextmanager
def trying(patience: Patience, console: Console) -> Iterator[Patience]:
    """Argument `patience` of `fsel.select`, with its progress shown."""
    if not patience.seconds:
        yield patience
        return
    with _watched(console, "trying", patience.seconds, TRIED) as going:
        yield Patience(
            patience.seconds, lambda made, planned, gone: going(gone, f"{made} of {planned} fits")
        )


@contextmanager
def refining(refine: Refine | None, console: Console) -> Iterator[Refine | None]:
    """Argument `refine` of `fsel.select`; None without `--refine`."""
    if refine is None:
        yield None
        return
    with _watched(console, "refining", refine.seconds, REFINED) as going:
        yield replace(refine, progress=lambda best, gone: going(gone, f"{best.gain:+.2f} dB"))
