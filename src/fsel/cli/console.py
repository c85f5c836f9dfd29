"""Output of the commands: what they print, and where."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fsel.captures.images.previews import Progress, in_silence
from fsel.captures.reporter import Reporter
from fsel.core.files import json_text
from fsel.core.wording import counted, in_minutes

STANDARD_OUTPUT = "standard output"  # in the place of a file's name
PATIENCE = 2.0  # seconds before a bar is shown
COMPILING = 3.0  # seconds of compiling before the first line; the next at four times as many
EVERY = 20.0  # seconds between two lines of a long loop where no terminal shows a bar
FEW = 10  # steps that differ too much to say how long those left take


@dataclass(frozen=True)
class Console(Reporter):
    """Lines for a person, or one JSON object for a script."""

    quiet: bool  # print nothing but errors
    as_json: bool  # print the result as JSON and no other line

    def say(self, label: str, text: str) -> None:
        """Print a line on standard output."""
        self.text(f"{label:9} {text}\n")

    def text(self, block: str) -> None:
        """Print lines on standard output, as they are."""
        if not (self.quiet or self.as_json):
            _print(block)

    def warn(self, text: str) -> None:
        """Print a line on standard error."""
        if not self.quiet:
            print(f"fsel: warning: {text}", file=sys.stderr, flush=True)

    def give(self, result: dict) -> None:
        """Print the result, for scripts that take it."""
        if self.as_json:
            _print(json_text(result) + "\n")

    @contextmanager
    def clock(self, label: str) -> Iterator[None]:
        """Show on a terminal what is done while a block runs whose steps are unknown."""
        if self.silent:
            yield
            return
        from tqdm import tqdm  # here: scripts do without, and it is slow to import

        with tqdm(desc=label, bar_format="{desc} ...", leave=False):
            yield

    @contextmanager
    def steps(self, label: str, unit: str = "step") -> Iterator[Callable[..., None]]:
        """Yield a function of steps made, all steps and, if known, the loss: a bar."""
        if self.quiet:
            yield lambda made, count, loss=None: None
            return
        if self.silent:
            report = _Report(label)
            yield lambda made, count, loss=None: report(made, count)
            return
        from tqdm import tqdm

        with tqdm(desc=label, delay=PATIENCE, leave=False, unit=unit) as shown:

            def advance(made: int, count: int, loss: float | None = None) -> None:
                shown.total = count
                if loss is not None:
                    shown.set_postfix(loss=f"{loss:.4f}", refresh=False)
                shown.update(made - shown.n)

            yield advance

    def bar(self, label: str) -> Progress:
        """Return a loop's progress bar on standard error, shown after two seconds."""
        if self.quiet:
            return in_silence
        if self.silent:
            return _Report(label).loop
        from tqdm import tqdm

        return lambda items, count: tqdm(items, label, count, delay=PATIENCE, leave=False)

    @property
    def silent(self) -> bool:
        """Check whether no bar is shown: with --quiet, and where no terminal would show it."""
        return self.quiet or not sys.stderr.isatty()


def _print(text: str) -> None:
    """Print on standard output; what cannot be printed is dropped when the process ends, too."""
    try:
        print(text, end="", flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise OSError(error.errno, error.strerror, STANDARD_OUTPUT) from error


class _Report:
    """A line on standard error now and then of how far a long loop is."""

    def __init__(self, label: str) -> None:
        self.label, self.said = label, time.monotonic()
        self.began = self.said

    def __call__(self, made: int, count: int) -> None:
        if (now := time.monotonic()) - self.said >= EVERY:
            self.said, left = now, in_minutes((now - self.began) * (count - made) / made)
            ends = f", {left} left" if count > FEW else ""
            print(f"fsel: {self.label}: {made} of {count}{ends}", file=sys.stderr, flush=True)

    def loop(self, items: Iterable, count: int) -> Iterator:
        """Yield the items of a loop."""
        for made, item in enumerate(items, 1):
            yield item
            self(made, count)


class Compiling:
    """A line on standard error now and then while functions are compiled, where that is long."""

    def __init__(self, console: Console) -> None:
        self.console, self.functions, self.seconds, self.told = console, 0, 0.0, COMPILING

    def __call__(self, seconds: float) -> None:
        """Count a function that was compiled."""
        self.functions, self.seconds = self.functions + 1, self.seconds + seconds
        if self.seconds >= self.told and not self.console.quiet:
            self.told = 4 * self.seconds
            said = f"{counted(self.functions, 'function')} in {self.seconds:.0f} s so far"
            print(f"fsel: compiling for this machine, once: {said}", file=sys.stderr, flush=True)
