"""Points seen several times by few frames: by hand, what is guaranteed, how it is asked for."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from selection_problems import random_problem, with_points
from small_captures import record_of, select

import fsel
from fsel.selection.multicover import ANGLE, multicover, sightings, wanted
from fsel.selectors.baselines.covisibility import Tracks, tracks


def tracks_of(sees, bearings=None):
    """Rows that see points: (M, n) bool; directions alike, or (M, n) angles in one plane."""
    point, row = np.nonzero(np.array(sees))
    angle = np.zeros(len(point)) if bearings is None else np.array(bearings)[point, row]
    order = np.argsort(row, kind="stable")
    count, n = np.shape(sees)
    return Tracks(
        point_start=np.searchsorted(point, np.arange(count + 1)),
        row=row,
        point=point,
        bearing=np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1),
        row_start=np.searchsorted(row[order], np.arange(n + 1)),
        seen=order,
    )


def test_the_fewest_rows_by_hand():
    sees = [[1, 1, 0, 0], [1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 0, 1]]
    assert multicover(tracks_of(sees), 1).tolist() == [0, 3]
    twice = multicover(tracks_of(sees), 2)
    assert sorted(twice.tolist()) == [0, 1, 2, 3]  # the last point is seen by one row: not counted
    assert wanted(tracks_of(sees), 2).tolist() == [True, True, True, False]


def test_two_directions_are_preferred_to_one():
    sees, wide = [[1, 1, 1, 1]], [[0, 0.1 * ANGLE, 0.2 * ANGLE, 3 * ANGLE]]
    assert multicover(tracks_of(sees, wide), 2).tolist() == [0, 3]
    assert len(multicover(tracks_of(sees), 2)) == 2  # where all look alike, any two do


@pytest.mark.parametrize("times", [1, 2, 3])
def test_every_point_is_seen_so_often_and_from_two_sides(times):
    problem = with_points(random_problem(16), count=40)
    seen = tracks(problem, problem.observed)
    rows = multicover(seen, times)
    counted, often = wanted(seen, times), sightings(seen, rows)
    assert (often[counted] >= times).all()
    for p in np.flatnonzero(counted) if times > 1 else []:
        of = slice(seen.point_start[p], seen.point_start[p + 1])
        bearing = seen.bearing[of]
        chosen = bearing[np.isin(seen.row[of], rows)]
        apart = max(np.arccos(np.clip(a @ b, -1, 1)) for a, b in combinations(chosen, 2))
        best = max(np.arccos(np.clip(a @ b, -1, 1)) for a, b in combinations(bearing, 2))
        assert apart >= min(ANGLE, best) / 2


def test_a_share_of_the_points_takes_fewer_rows():
    problem = with_points(random_problem(30), count=200)
    seen = tracks(problem, problem.observed)
    every, most = multicover(seen, 2), multicover(seen, 2, 0.8)
    assert len(most) < len(every)
    np.testing.assert_array_equal(most, every[: len(most)])
    reached = [(sightings(seen, every[:m])[wanted(seen, 2)] >= 2).mean() for m in range(30)]
    assert reached[len(most)] >= 0.8 > reached[len(most) - 1]


def test_it_is_not_far_from_the_smallest_cover():
    for seed in range(10):
        sees = np.random.default_rng(seed).random((12, 9)) < 0.3
        sees = sees[sees.any(axis=1)]
        rows = multicover(tracks_of(sees), 1)
        best = next(
            count
            for count in range(1, 10)
            for some in combinations(range(9), count)
            if sees[:, some].any(axis=1).all()
        )
        assert len(rows) <= best * (1 + np.log(sees.sum(axis=0).max()))


def test_a_cover_takes_as_few_as_needed_and_the_rest_by_the_rule(ring, tmp_path, capsys):
    assert select(ring, "--cover", 3, "-o", tmp_path / "out") == 0
    said, content = capsys.readouterr().out, record_of(tmp_path / "out")
    cover, few = content["cover"], len(content["frames"])
    assert cover["frames"] == few
    assert cover["picks"] == [0, 0, 0, cover["points"]]
    assert sum(cover["even"]) == cover["points"]
    assert f"{few} frames are enough to see each 3 times" in said
    assert "enough to see each 3 times" in (tmp_path / "out" / "report.html").read_text()
    assert select(ring, "-k", few + 2, "--cover", 3, "-o", tmp_path / "more") == 0
    names = [entry["name"] for entry in content["frames"]]
    more = record_of(tmp_path / "more")
    assert [entry["name"] for entry in more["frames"]][:few] == names
    assert len(more["frames"]) == few + 2
    assert more["tried"] is None


def test_covers_that_cannot_be_are_refused(ring):
    capture = fsel.read_capture(ring, long_side=32)
    few = len(fsel.select(capture, None, cover=3).indices)
    for asked, said in (
        ({"k": few - 1, "cover": 3}, f"k is {few - 1}, and a cover of 3 takes {few} frames"),
        ({"k": 6, "cover": 1, "cover_share": 1.5}, "share of a cover is 1.5; allowed: above 0"),
        ({"k": 6, "cover_share": 0.5}, "cover_share is 0.5, but no cover is given"),
        ({"k": None}, "neither k nor cover is given"),
        ({"k": 6, "cover": -1}, "cover is -1; allowed: 1 or more"),
        ({"k": 6, "cover": 25}, "cover is 25, and no point of .* is seen by so many of 24"),
        ({"k": "auto", "cover": 1}, "combined with an automatic number of frames"),
        ({"k": 6, "cover": 1, "method": "uniform"}, "uniform, which does not score frames"),
        ({"k": 6, "cover": 1, "always": [0]}, "frames to select always"),
        ({"k": 6, "cover": 1, "patience": 3}, "patience is 3 s, but a cover of the points"),
    ):
        with pytest.raises(ValueError, match=said):
            fsel.select(capture, **asked)
    with pytest.raises(ValueError, match="has no sparse points with observations"):
        fsel.select(replace(capture, points=None), None, cover=2)
