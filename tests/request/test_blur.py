"""Which picks are blurred, and what takes their place."""

import numpy as np
import pytest
from selection_problems import capture_of

import fsel
from fsel.data.problem import Problem
from fsel.images import previews
from fsel.request import blur, swaps
from fsel.request.blur import blurred, exchanged
from fsel.request.refine import Swapped

PICKS = np.array([30, 10, 20, 2])


def walk(without=(), given=()):
    """Cameras on a line, one a metre, that look ahead; some are not to be selected."""
    count = 36
    centers = np.zeros((count, 3))
    centers[:, 0] = np.arange(count)
    capture = capture_of(centers, np.tile(np.eye(3), (count, 1, 1)))
    pool = np.setdiff1d(np.arange(count), without)
    return Problem(
        capture=capture,
        candidates=pool,
        proxies=pool[:1],
        targets=capture.view(pool[:1]),
        descriptors=np.zeros((count, 0), np.float32),
        sharpness=np.zeros(count),
        given=np.array(given, np.int64),
    )


def made(sharpness, **changed):
    values = np.full(36, 100.0)
    values[list(sharpness)] = list(sharpness.values())
    return exchanged(walk(**changed), PICKS, values.__getitem__).tolist()


@pytest.mark.parametrize(
    ("sharpness", "changed", "instead"),
    [
        ({}, {}, 10),
        ({10: 41}, {}, 10),  # none of the four beside it is 2.5 times as sharp
        ({10: 40}, {}, 9),  # of equally sharp ones, the closest; of equally close ones, the first
        ({10: 40, 12: 101}, {}, 12),  # the sharpest within two
        ({10: 40, 13: 200}, {}, 9),  # not one beyond
        ({10: 40, 8: 99, 9: 99, 11: 99, 12: 99, 7: 300}, {}, 10),
        ({8: 50, 9: 50, 10: 40, 11: 50, 12: 100}, {}, 12),  # in a burst of blurred ones, too
        ({10: 40}, {"given": [10]}, 10),
        ({10: 40, 12: 300}, {"without": [12]}, 9),
        ({10: 40, 13: 200}, {"without": [7, 11]}, 13),  # then it is one of the four closest
        ({10: 0, 8: 0, 9: 0, 11: 0, 12: 0}, {}, 10),  # nothing to see is not blurred
    ],
)
def test_a_blurred_pick_gives_way(sharpness, changed, instead):
    assert made(sharpness, **changed) == [30, instead, 20, 2]


def test_any_frame_may_be_told_to_be_blurred():
    values = np.full(36, 100.0)
    values[[10, 2, 20]] = [40, 41, 0]
    blurry = blurred(walk().capture, PICKS, values.__getitem__)
    assert blurry.tolist() == [False, True, True, False]


def test_blurred_frames_are_the_same_in_blocks(monkeypatch):
    values = np.where(np.arange(36) % 5, 100.0, 40.0)
    capture, frames = walk().capture, np.arange(36)
    whole = blurred(capture, frames, values.__getitem__)
    monkeypatch.setattr(blur, "BLOCK", 7)
    np.testing.assert_array_equal(blurred(capture, frames, values.__getitem__), whole)
    assert frames[whole].tolist() == list(range(0, 36, 5))


def test_a_frame_alone_is_not_blurred():
    alone = walk().capture.subset(np.array([3]))
    assert blurred(alone, np.array([0]), np.ones(1).__getitem__).tolist() == [False]


def test_no_frame_is_picked_twice():
    picks = np.array([10, 9, 11, 8])
    values = np.full(36, 100.0)
    values[10] = 10
    assert exchanged(walk(), picks, values.__getitem__).tolist() == [12, 9, 11, 8]
    values[[9, 10]] = 10
    # the first takes what the second might have taken too
    assert exchanged(walk(), np.array([10, 9]), values.__getitem__).tolist() == [11, 8]


def test_the_first_and_the_last_frame_have_neighbours_on_one_side():
    values = np.full(36, 100.0)
    values[[0, 35]] = 10
    assert exchanged(walk(), np.array([0, 35]), values.__getitem__).tolist() == [1, 34]


def test_only_frames_around_the_picks_are_looked_at_and_none_that_is_held_out():
    measured = []

    def sharpness_of(frames):
        measured.append(frames.tolist())
        return np.full(len(frames), 7.0)

    exchanged(walk(without=[11, 12]), np.array([10]), sharpness_of)
    assert measured == [[7, 8, 9, 10, 13]]


@pytest.mark.parametrize("method", ["fsel", "uniform"])
def test_picks_of_fsel_alone_are_exchanged_and_the_selection_says_so(method):
    capture = walk().capture
    plain = fsel.select(capture, 6, method=method, sharpness=np.zeros(36))
    assert plain.exchanged == {}
    sharpness = np.full(36, 100.0)
    sharpness[plain.indices[2]] = 1
    exchanged = fsel.select(capture, 6, method=method, sharpness=sharpness)
    if method == "uniform":
        assert exchanged.names == plain.names
        return
    (came, left), *others = exchanged.exchanged.items()
    assert (left, others) == (plain.names[2], [])
    assert exchanged.names == (*plain.names[:2], came, *plain.names[3:])
    assert abs(exchanged.indices[2] - plain.indices[2]) <= 4
    np.testing.assert_array_equal(np.isnan(exchanged.scores), np.arange(6) == 2)
    by_measuring = fsel.select(capture, 6, method=method, sharpness=sharpness.__getitem__)
    assert by_measuring.names == exchanged.names


def test_a_stand_in_that_swaps_took_out_again_stands_for_nothing(monkeypatch):
    capture, sharpness = walk().capture, np.full(36, 100.0)
    plain = fsel.select(capture, 6, patience=0, sharpness=sharpness)
    sharpness[plain.indices[:2]] = 1
    both = fsel.select(capture, 6, patience=0, sharpness=sharpness)
    assert list(both.exchanged) == list(both.names[:2])
    free = np.setdiff1d(np.arange(36), np.concatenate([plain.indices, both.indices]))[0]

    def refined(problem, picks, refine, seed):
        return Swapped(np.array([free, *picks[1:]]), 0.1, 2)

    monkeypatch.setattr(swaps, "refined", refined)
    exchanged = fsel.select(capture, 6, patience=0, sharpness=sharpness, refine=1.0)
    assert exchanged.exchanged == {both.names[1]: plain.names[1]}
    np.testing.assert_array_equal(np.isnan(exchanged.scores), np.arange(6) < 2)


def test_no_file_is_measured_twice(monkeypatch):
    opened = []

    def measure(files, longest, progress):
        opened.append(list(files))
        return np.array([float(file) for file in files])

    monkeypatch.setattr(previews, "sharpness_of_files", measure)
    sharpness_of = previews.sharpness_among(["0", "10", "20", "30"], 64)
    assert sharpness_of(np.array([2, 0])).tolist() == [20, 0]
    assert sharpness_of(np.array([0, 3, 2])).tolist() == [0, 30, 20]
    assert opened == [["20", "0"], ["30"]]
