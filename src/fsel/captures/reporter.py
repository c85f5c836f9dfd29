"""How work on a capture is reported to a person."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from fsel.captures.images.previews import Progress, in_silence


class Reporter:
    """What tells a person of progress, as the command's console does; this one is silent."""

    def say(self, label: str, text: str) -> None:
        """Print a line."""

    def warn(self, text: str) -> None:
        """Print a warning."""

    def bar(self, label: str) -> Progress:
        """Return what wraps a loop."""
        return in_silence

    def clock(self, label: str) -> AbstractContextManager[None]:
        """Return a block whose time is shown."""
        return nullcontext()


SILENT = Reporter()
