"""Threads that help with ranges of a loop; see `fsel.core.threads`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Lock

import numpy as np

from fsel.core.compiled import plain

MOST = 1024  # helpers; one starts when there is work for one more
LOOKS = 500_000  # at a flag before a thread sleeps: a third of a millisecond


class Job:
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


class Helpers:
    """Threads that make calls, and look out for the next for a moment before they sleep: to wake
    one takes as long as a range of a small image."""

    def __init__(self) -> None:
        self._pool, self._jobs = ThreadPoolExecutor(MOST, "fsel"), deque[Job]()
        self._given, self._looking, self._turn = np.zeros(1, np.int64), 0, Lock()

    def begin(self, jobs: Sequence[Job]) -> None:
        """Let helpers make calls: those who look out for one, and others."""
        with self._turn:
            self._jobs.extend(jobs)
            self._given[0] += 1
            asleep = len(self._jobs) - self._looking
        for _ in range(asleep):
            self._pool.submit(self._serve)

    def end(self, jobs: Sequence[Job]) -> None:
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


HELPERS = Helpers()
