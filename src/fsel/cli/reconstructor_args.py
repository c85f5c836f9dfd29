"""Reconstructors as the commands use them: checked, bound, fitted with progress, stopped."""

from __future__ import annotations

import argparse
import inspect
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numpy as np

from fsel.cli.console import Console
from fsel.core.capture import Capture
from fsel.core.registry import unknown
from fsel.reconstruct import RECONSTRUCTORS, Model, Reconstructor, check_needs

KEPT = "interrupted: the model so far is written; again to give up"
WRITE_PLY = ("splats", "gaussians")  # whose models are Gaussians
STEPPED = ("gaussians",)  # that take --steps
CONFIGURED = ("external",)  # that nothing but a configuration can describe


def checked(args: argparse.Namespace, **settings: int) -> dict[str, int]:
    """The settings of `--reconstructor` that the command line gives beside some.

    Raises:
        ValueError: for a reconstructor that is unknown, cannot work here, or takes no `--steps`.
    """
    offered = [name for name in RECONSTRUCTORS if name not in CONFIGURED]
    if args.reconstructor not in offered:
        raise unknown("reconstructor", args.reconstructor, offered)
    if args.steps is not None and args.reconstructor not in STEPPED:
        raise ValueError(
            f"--steps is {args.steps}, and {args.reconstructor} takes none; allowed with: "
            f"{', '.join(STEPPED)}"
        )
    settings |= {} if args.steps is None else {"steps": args.steps}
    check_needs({"name": args.reconstructor, "settings": settings})
    return settings


def bound(args: argparse.Namespace, capture: Capture, **settings: int) -> Reconstructor:
    """The reconstructor that the command line names, bound to a capture."""
    return RECONSTRUCTORS.checked(args.reconstructor)(capture, **checked(args, **settings))


def fitted(
    reconstructor: Reconstructor,
    frames: np.ndarray,
    console: Console,
    watch: Callable[[Any], None] | None = None,
) -> Model:
    """A model of some frames; `watch` sees it from time to time, of those that can be watched.

    Reconstructors that take steps show them, with the time left. Ctrl-C ends those that can be
    stopped, and the model so far is returned; a second Ctrl-C gives up.
    """
    fit: Callable[..., Model] = reconstructor.fit
    taken = inspect.signature(fit).parameters
    if "progress" not in taken:
        with console.clock("reconstructing"):
            return fit(frames)
    with console.steps("reconstructing") as progress:
        if "stop" not in taken:
            return fit(frames, progress=progress)
        watched = {"watch": watch} if "watch" in taken else {}
        with stopped_by_interrupt(console, KEPT) as stop:
            return fit(frames, progress=progress, stop=stop, **watched)


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
