"""Loops in ranges, on several threads, with the same result on any number of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from itertools import count, pairwise
from threading import Event, Lock, local
from typing import Any

from fsel.core.limits import threads

# share: how many threads this one may start, if unset all; ended: nobody waits for its work
_here = local()


def ranges(length: int, least: int, each: int = 4) -> list[tuple[int, int]]:
    """Cut 0..length into (first, last) of at least `least`, at most `each` for every thread.

    On one thread, and within `spread`, it is one range.
    """
    if (ended := getattr(_here, "ended", None)) and ended.is_set():
        raise CancelledError
    workers = _share()
    parts = max(min(workers * each, length // least), 1) if workers > 1 else 1
    return list(pairwise(length * i // parts for i in range(parts + 1)))


def spread(work: Callable[[int, int], Any], parts: Sequence[tuple[int, int]]) -> list[Any]:
    """Return `work(first, last)` of every range, in their order; it should leave Python's lock."""
    if len(parts) == 1:
        return [work(*parts[0])]
    from fsel.core.helpers import HELPERS, Job  # here: numba takes long to import

    results, numbers = [None] * len(parts), count()

    def drain() -> None:
        own, _here.share = getattr(_here, "share", 0), 1
        try:
            while (at := next(numbers)) < len(parts):
                results[at] = work(*parts[at])
        finally:
            _here.share = own

    jobs = [Job(drain) for _ in range(min(_share(), len(parts)) - 1)]
    HELPERS.begin(jobs)
    try:
        drain()
    finally:
        HELPERS.end(jobs)
    return results


def side_by_side(work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
    """Yield `work(item)` of every item, in their order, with as many at once as there are threads.

    Each has its share of the threads for its ranges. Once the iterator is closed no more begin, and
    those that run end at their next loop in ranges.
    """
    workers = min(_share(), len(items))
    if workers <= 1:
        yield from map(work, items)
        return

    share, ended = _share() // workers, Event()

    def begin() -> None:
        _here.share, _here.ended = share, ended

    with ThreadPoolExecutor(workers, "fsel-fit", begin) as pool:
        try:
            yield from pool.map(work, items)
        finally:
            ended.set()


def _share() -> int:
    return getattr(_here, "share", 0) or threads()


class InOrder:
    """A function of ranges, called on several threads, that works on them one by one, from 0 on."""

    def __init__(self, work: Callable[[int, int], Any]) -> None:
        self._work, self._ready, self._at, self._turn = work, dict[int, int](), 0, Lock()

    def __call__(self, first: int, last: int) -> None:
        """Work on a range and those that waited for it, or leave it to the thread that does."""
        self._ready[first] = last
        while self._at in self._ready and self._turn.acquire(blocking=False):
            try:
                if (end := self._ready.pop(self._at, None)) is not None:
                    self._work(self._at, end)
                    self._at = end
            finally:
                self._turn.release()
