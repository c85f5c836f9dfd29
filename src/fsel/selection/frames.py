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
LISTS = (".txt", ".lst", ".list")  # endings of files of frame names


def frames_wished(capture: Capture, wish: Wish) -> np.ndarray:
    """(n,) int64 frames of a wish, which may be empty: names, numbers, and files of names."""
    if wish is None or not is_stated(wish):
        return np.empty(0, np.int64)
    words = _words(wish)
    files = [w for w in words if w not in capture.names and Path(w).is_file()]
    if not files:
        return frames_of(capture, words or wish)
    found = [named_in(Path(w), capture) if w in files else frames_of(capture, [w]) for w in words]
    return np.array(list(dict.fromkeys(np.concatenate(found).tolist())), np.int64)


def is_stated(wish: Wish) -> bool:
    """Return whether frames are named; files of their names must be there."""
    words = _words(wish)
    for word in words:
        if Path(word).suffix in LISTS and not Path(word).is_file():
            raise FileNotFoundError(f"{word}: no such file of frame names, one a line")
    return bool(words) or (not isinstance(wish, str | Path | None) and np.size(wish) > 0)


def _words(wish: Wish) -> list[str]:
    """Return the names and files of a wish; none where it is of numbers."""
    words = wish if isinstance(wish, list | tuple) else [wish]
    return [str(word) for word in words if isinstance(word, str | Path)]


def named_in(path: Path, capture: Capture) -> np.ndarray:
    """(n,) numbers of the distinct frames that a file names, one a line, in its order."""
    names = [line.strip() for line in read_text(path).splitlines()]
    return _numbers(capture, [name for name in names if name], path)


def frames_of(capture: Capture, frames: ArrayLike | Wish, what: str = "frames") -> np.ndarray:
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
