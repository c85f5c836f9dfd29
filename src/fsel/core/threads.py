"""Loops in ranges, on several threads, with the same result on any number of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import suppress
from itertools import count, pairwise
from threading import Event, Lock, local
from typing import Any

import numpy as np

from fsel.core.compiled import plain
from fsel.core.limits import threads

MOST = 1024  # helpers; they start when there is work for one more
LOOKS = 500_000  # at a flag before a thread sleeps: a third of a millisecond

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
    results, numbers = [None] * len(parts), count()

    def drain() -> None:
        own, _here.share = getattr(_here, "share", 0), 1
        try:
            while (at := next(numbers)) < len(parts):
                results[at] = work(*parts[at])
        finally:
            _here.share = own

    jobs = [_Job(drain) for _ in range(min(_share(), len(parts)) - 1)]
    _HELPERS.begin(jobs)
    try:
        drain()
    finally:
        _HELPERS.end(jobs)
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


class _Job:
    """A call for a helper to make, once."""

    def __init__(self, call: Callable[[], None]) -> None:
        self.call, self.ended, self.looks = call, *np.zeros((2, 1), np.int64)
        self.error: BaseException | None = None
        self.running = Lock()
        self.running.acquire()

    def make(self) -> None:
        """Make the call, and keep its error."""
        try:
            self.call()
        except BaseException as error:
            self.error = error
        self.running.release()


class _Helpers:
    """Threads that make calls, and look out for the next for a moment before they sleep: to wake
    one takes as long as a range of a small image."""

    def __init__(self) -> None:
        self._pool, self._jobs = ThreadPoolExecutor(MOST, "fsel"), deque[_Job]()
        self._given, self._looking, self._turn = np.zeros(1, np.int64), 0, Lock()

    def begin(self, jobs: Sequence[_Job]) -> None:
        """Let helpers make calls: those who look out for one, and others."""
        with self._turn:
            self._jobs.extend(jobs)
            self._given[0] += 1
            asleep = len(self._jobs) - self._looking
        for _ in range(asleep):
            self._pool.submit(self._serve)

    def end(self, jobs: Sequence[_Job]) -> None:
        """Wait for the calls that helpers began, drop the others, and raise the first error."""
        for job in jobs:
            try:
                self._jobs.remove(job)
            except ValueError:
                _look(job.ended, 1, job.looks)
                job.running.acquire()
        for job in jobs:
            if job.error is not None:
                raise job.error

    def _serve(self) -> None:
        ended, looks = np.zeros((2, 1), np.int64)
        while True:
            given = self._given[0]
            while self._jobs:
                ended[0] = 1
                with suppress(IndexError):
                    job = self._jobs.popleft()
                    ended = job.ended
                    job.make()
            with self._turn:
                self._looking += 1
            _say_and_look(ended, self._given, given + 1, looks)
            with self._turn:
                self._looking -= 1
                if not self._jobs:
                    return


@plain
def _look(flag: np.ndarray, value: int, looks: np.ndarray) -> None:
    """Wait until a (1,) flag is as large as a value, or some time has passed; the count in (1,)
    `looks` may be the flag, for all that the compiler knows, so that it is read anew."""
    for looks[0] in range(LOOKS):
        if flag[0] >= value:
            return


@plain
def _say_and_look(ended: np.ndarray, flag: np.ndarray, value: int, looks: np.ndarray) -> None:
    """Say that a call has ended, while who waits for it can have Python's lock, and look."""
    ended[0] = 1
    _look(flag, value, looks)


_HELPERS = _Helpers()
