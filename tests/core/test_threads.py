"""The number of threads: who says it, and that ranges cover all on any number of them."""

import math
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import fsel
from fsel.core import limits
from fsel.core.threads import InOrder, ranges, side_by_side, spread


@pytest.fixture(autouse=True)
def unset(monkeypatch):
    monkeypatch.setenv(limits.THREADS, "1")  # restored after the test
    fsel.set_threads(None)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)


def test_threads_are_set_or_all_cores(monkeypatch):
    assert limits.threads() == limits.cores()
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    assert limits.threads() == 7
    monkeypatch.setenv(limits.THREADS, "3")
    assert limits.threads() == 3
    fsel.set_threads(5)
    assert limits.threads() == 5


@pytest.mark.parametrize("wrong", [0, -1, 1.5, True, "2"])
def test_other_numbers_are_refused(wrong, monkeypatch):
    with pytest.raises(ValueError, match="threads"):
        fsel.set_threads(wrong)
    monkeypatch.setenv(limits.THREADS, "many")
    with pytest.raises(ValueError, match=limits.THREADS):
        limits.threads()


@pytest.mark.parametrize(
    ("text", "cores"), [("150000 100000", 2), ("50000 100000", 1), ("max 100000", math.inf)]
)
def test_a_container_has_its_quota(text, cores, tmp_path, monkeypatch):
    file = tmp_path / "cpu.max"
    file.write_text(text)
    assert limits.quota(file) == cores
    monkeypatch.setattr(limits, "QUOTA", file)
    monkeypatch.setattr(limits.os, "sched_getaffinity", lambda _: range(8), raising=False)
    assert limits.cores() == min(cores, 8)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_ranges_cover_all_in_order(count):
    fsel.set_threads(count)
    parts = ranges(1000, 30)
    assert len(parts) == (1 if count == 1 else 4 * count)
    assert [i for a, b in spread(lambda a, b: (a, b), parts) for i in range(a, b)] == [*range(1000)]
    assert ranges(59, 30) == [(0, 59)]


def test_threads_work_at_once_and_one_alone_within():
    fsel.set_threads(2)
    both = threading.Barrier(2, timeout=60)
    assert spread(lambda a, b: both.wait() >= 0 and len(ranges(100, 1)), ranges(2, 1, 1)) == [1, 1]


def test_items_run_side_by_side_with_a_share_of_the_threads_each():
    fsel.set_threads(4)
    both = threading.Barrier(2, timeout=60)
    made = side_by_side(lambda i: (i, both.wait() >= 0, len(ranges(99, 1, 1))), [3, 1])
    assert [*made] == [(3, True, 2), (1, True, 2)]
    assert [*side_by_side(lambda i: len(ranges(99, 1, 1)), [0])] == [4]


def test_what_runs_ends_once_nobody_waits_for_it():
    fsel.set_threads(2)

    def endless(number):
        while number:
            ranges(9, 1)
        return number

    made = side_by_side(endless, [0, 1, 2])
    assert next(made) == 0
    made.close()


def test_an_error_of_a_thread_is_raised():
    fsel.set_threads(3)
    with pytest.raises(ZeroDivisionError):
        spread(lambda a, b: 1 // (11 - b), ranges(12, 1))
    assert len(ranges(100, 1)) == 12


def test_callers_on_several_threads_share_the_helpers():
    fsel.set_threads(3)
    parts = [(i, i + 1) for i in range(7)]

    def call(number):
        for turn in range(100):
            time.sleep(0.0005 * (turn % 3))  # helpers wait, or sleep already
            assert spread(lambda a, b: number * a, parts) == [number * i for i in range(7)]
            with pytest.raises(ZeroDivisionError):
                spread(lambda a, b: 1 // (a - 3), parts)
        return number

    with ThreadPoolExecutor(4) as callers:
        assert [*callers.map(call, range(4))] == [0, 1, 2, 3]


def test_ranges_that_are_ready_in_any_order_are_taken_in_theirs():
    taken = []
    call = InOrder(lambda a, b: taken.append((a, b)))
    for part in [(2, 5), (5, 6), (0, 2), (6, 9)]:
        call(*part)
    assert taken == [(0, 2), (2, 5), (5, 6), (6, 9)]
