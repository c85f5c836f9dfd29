"""Reconstructors as the commands use them: checked, bound, stopped."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from fsel.cli.console import Console
from fsel.core.capture import Capture
from fsel.core.registry import unknown
from fsel.reconstruct import RECONSTRUCTORS, Reconstructor, check_needs

WRITE_PLY = ("splats", "gaussians")  # whose models are Gaussians
STEPPED = ("gaussians",)  # that take --steps, and can be stopped
CONFIGURED = ("external",)  # that nothing but a configuration can describe


def checked(args: argparse.Namespace, **settings: float) -> dict[str, float]:
    """Return the settings given, and `--steps`, once `--reconstructor` is known to take them."""
    offered = [name for name in RECONSTRUCTORS if name not in CONFIGURED]
    if args.reconstructor not in offered:
        raise unknown("reconstructor", args.reconstructor, offered)
    if args.steps is not None:
        if args.reconstructor not in STEPPED:
            raise ValueError(
                f"--steps is {args.steps}, but {args.reconstructor} takes no steps; allowed with: "
                f"{', '.join(STEPPED)}"
            )
        settings["steps"] = args.steps
    check_needs({"name": args.reconstructor, "settings": settings})
    return settings


def bound(args: argparse.Namespace, capture: Capture, **settings: float) -> Reconstructor:
    """Bind the reconstructor that the command line names to a capture."""
    return RECONSTRUCTORS.checked(args.reconstructor)(capture, **checked(args, **settings))


@contextmanager
def stopped_by_interrupt(console: Console, kept: str) -> Iterator[Callable[[], bool]]:
    """Test of whether Ctrl-C was pressed; the second time it interrupts as usual."""
    pressed: list[int] = []

    def press(number: int, frame: FrameType | None) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)
        console.warn(kept)

    previous = signal.signal(signal.SIGINT, press)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, previous)
