"""Frames of a capture that a person names, in words or in a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsel.captures.parsing import read_text, slashed
from fsel.core.capture import Capture
from fsel.core.wording import counted, unexpected

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Wish = None | str | Path | Sequence[str] | Sequence[int] | np.ndarray


def frames_wished(capture: Capture, wish: Wish) -> np.ndarray:
    """(n,) int64 frames of a list, which may be empty, or a file of them."""
    if wish is None or not is_stated(wish):
        return np.empty(0, np.int64)
    return (
        named_in(Path(wish), capture) if isinstance(wish, str | Path) else frames_of(capture, wish)
    )


def is_stated(wish: Wish) -> bool:
    """Return whether frames are named; a file of their names must be there."""
    if not isinstance(wish, str | Path):
        return wish is not None and np.size(wish) > 0
    if not Path(wish).is_file():
        raise FileNotFoundError(f"{wish}: no such file of frame names, one a line")
    return True


def named_in(path: Path, capture: Capture) -> np.ndarray:
    """(n,) numbers of the distinct frames that a file names, one a line, in its order."""
    names = [line.strip() for line in read_text(path).splitlines()]
    return _numbers(capture, [name for name in names if name], path)


def frames_of(capture: Capture, frames: ArrayLike, what: str = "frames") -> np.ndarray:
    """(n,) int64 frames by name or number, or as a mask of all, each once, in their order.

    Raises:
        TypeError: for anything else; `what` names it.
        ValueError: for none, or a frame that the capture does not have.
    """
    given = np.asarray(frames)
    if given.dtype == bool and given.shape == (len(capture),):
        given = np.flatnonzero(given)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iuU"):
        raise unexpected(what, frames, f"names or numbers of the {len(capture)} frames")
    return _numbers(capture, given.tolist())


def _numbers(
    capture: Capture, named: Sequence[Any] | np.ndarray, path: Path | None = None
) -> np.ndarray:
    """(n,) int64 frames by name or number, each once, in the order of `named`."""
    where = f"{path}: " if path else ""
    if not len(named):
        raise ValueError(f"{where}no frame is named")
    rows = {name: i for i, name in enumerate(capture.names)}
    named = [slashed(f) if isinstance(f, str) and f not in rows else f for f in named]
    numbers = [rows.get(f, -1) if isinstance(f, str) else int(f) for f in named]
    known = range(len(capture))
    if unknown := [frame for frame, n in zip(named, numbers, strict=True) if n not in known]:
        raise ValueError(
            f"{where}{counted(len(unknown), 'frame')} not in the capture, the first "
            f"{unknown[0]!r}; its names are like {capture.names[0]!r}"
        )
    return np.array(list(dict.fromkeys(numbers)))
