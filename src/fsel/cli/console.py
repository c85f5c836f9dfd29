"""Output of the commands: what they print, and where."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event, Thread

from fsel.captures.images.previews import Progress, in_silence

PATIENCE = 2.0  # seconds before a bar is shown
TICK = 0.5  # seconds between two updates of a clock
EVERY = 20.0  # seconds between two lines of a long loop where no terminal shows a bar


@dataclass(frozen=True)
class Console:
    """Lines for a person, or one JSON object for a script.

    Attributes:
        quiet: print nothing but errors.
        as_json: print the result as JSON and no other line.
    """

    quiet: bool
    as_json: bool

    def say(self, label: str, text: str) -> None:
        """A line on standard output."""
        if not (self.quiet or self.as_json):
            print(f"{label:9} {text}", flush=True)

    def text(self, block: str) -> None:
        """Lines on standard output, as they are."""
        if not (self.quiet or self.as_json):
            print(block, end="", flush=True)

    def warn(self, text: str) -> None:
        """A line on standard error."""
        if not self.quiet:
            print(f"fsel: warning: {text}", file=sys.stderr, flush=True)

    def give(self, result: dict) -> None:
        """Print the result, for scripts that take it."""
        if self.as_json:
            print(json.dumps(result, indent=1))

    @property
    def silent(self) -> bool:
        """Check whether bars and clocks are left out: they are shown on terminals alone, without
        --quiet."""
        return self.quiet or not sys.stderr.isatty()

    @contextmanager
    def clock(self, label: str) -> Iterator[None]:
        """The seconds that a block takes, on standard error after two, where steps are unknown."""
        if self.silent:
            yield
            return
        started, done = time.time(), Event()

        def tick() -> None:
            if done.wait(PATIENCE):
                return
            from tqdm import tqdm

            with tqdm(desc=label, bar_format="{desc}: {elapsed}", leave=False) as shown:
                shown.start_t = started
                while not done.wait(TICK):
                    shown.refresh()

        thread = Thread(target=tick, daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()

    @contextmanager
    def steps(self, label: str) -> Iterator[Callable[[int, int, float], None]]:
        """Progress of a function of steps made, all steps and the loss: as `bar` shows it."""
        if self.quiet:
            yield lambda made, count, loss: None
            return
        if self.silent:
            told = _lines(label)
            yield lambda made, count, loss: told(made, count)
            return
        from tqdm import tqdm

        with tqdm(desc=label, delay=PATIENCE, leave=False, unit="step") as shown:

            def advance(made: int, count: int, loss: float) -> None:
                shown.total = count
                shown.set_postfix(loss=f"{loss:.4f}", refresh=False)
                shown.update(made - shown.n)

            yield advance

    @contextmanager
    def seconds(self, label: str, most: float) -> Iterator[Callable[[float, str], None]]:
        """Progress bar of a function of the seconds gone, of `most`, and a word beside them."""
        if self.silent:
            yield lambda gone, word: None
            return
        from tqdm import tqdm

        form = "{desc}: {n:.0f} of {total:.0f} s {bar} {postfix}"
        with tqdm(desc=label, total=most, leave=False, bar_format=form) as shown:

            def advance(gone: float, word: str) -> None:
                shown.set_postfix_str(word, refresh=False)
                shown.update(min(gone, most) - shown.n)

            yield advance

    def bar(self, label: str) -> Progress:
        """A progress bar on standard error after two seconds; lines where that is no terminal."""
        if self.quiet:
            return in_silence
        if self.silent:
            return lambda items, count: _looped(label, items, count)
        from tqdm import tqdm

        def progress(items: Iterable, count: int) -> Iterable:
            return tqdm(items, label, count, delay=PATIENCE, leave=False)

        return progress


def _lines(label: str) -> Callable[[int, int], None]:
    """Function of what is made, of how many: it prints a line on standard error now and then."""
    started = said = time.monotonic()

    def tell(made: int, count: int) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= EVERY:
            said, gone = now, now - started
            left = gone / made * (count - made)
            line = f"{label}: {made} of {count} after {gone:.0f} s, about {left:.0f} s left"
            print(f"fsel: {line}", file=sys.stderr, flush=True)

    return tell


def _looped(label: str, items: Iterable, count: int) -> Iterator:
    """Items of a loop that `_lines` tells of."""
    tell = _lines(label)
    for made, item in enumerate(items, 1):
        yield item
        tell(made, count)
