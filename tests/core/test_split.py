"""Targets, proxies and candidates: a partition, a best assignment, the paper's counts."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from selection_problems import capture_of, random_capture

from fsel.core.files import repeated, stacked
from fsel.core.geometry import pose_distance
from fsel.core.split import Split, coverage_split, evaluation_split, splits_in

COVERAGES = (25, 40, 60, 80, 100)


def splits(capture):
    yield evaluation_split(capture, 0, 0)
    yield from (coverage_split(capture, coverage, 0) for coverage in COVERAGES)


def test_a_split_is_a_partition_of_ascending_frames():
    capture = random_capture(70)
    for split in splits(capture):
        parts = np.concatenate([split.targets, split.proxies, split.candidates])
        np.testing.assert_array_equal(np.sort(parts), np.arange(70))
        assert len(split.proxies) == len(split.targets)
        for part in (split.targets, split.candidates, split.region):
            assert part.dtype == np.int64
            assert (np.diff(part) > 0).all()
        assert np.isin(split.region, split.candidates).all()


def test_the_papers_counts_of_targets():
    capture = random_capture(160)
    counts = [len(coverage_split(capture, c, 1).targets) for c in COVERAGES]
    assert counts == [4, 6, 9, 12, 15]
    assert len(evaluation_split(capture, 0, 0).targets) == 15


def test_proxies_minimise_the_summed_distance():
    capture = random_capture(9, seed=4)
    split = evaluation_split(capture, 0, 5, targets=3)
    rest = np.setdiff1d(np.arange(9), split.targets)
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[split.targets], axes[split.targets], centers[rest], axes[rest])
    best = min(permutations(range(6), 3), key=lambda p: cost[range(3), p].sum())
    np.testing.assert_array_equal(split.proxies, rest[list(best)])


@pytest.mark.parametrize("far", [30, 1e6])
def test_cameras_far_beyond_all_others_have_no_role(far):
    capture = random_capture(70)
    centers = capture.centers.copy()
    centers[[7, 33]] += far * np.abs(centers).max()
    stray = capture_of(centers, capture.world_to_camera[:, :, :3])
    for split in splits(stray):
        parts = np.concatenate([split.targets, split.proxies, split.candidates, split.region])
        np.testing.assert_array_equal(np.unique(parts), np.setdiff1d(np.arange(70), [7, 33]))
        again = Split.from_table(split.table(stray.names))
        np.testing.assert_array_equal(again.candidates, split.candidates)


def test_draws_and_seeds_differ_and_repeat():
    capture = random_capture(80)
    drawn = [evaluation_split(capture, d, s).targets.tolist() for s in (0, 1) for d in (0, 1, 2)]
    assert len({tuple(t) for t in drawn}) == 6
    assert evaluation_split(capture, 2, 1).targets.tolist() == drawn[5]


def test_coverage_targets_lie_in_a_ball_around_an_anchor():
    capture = random_capture(100, seed=2)
    for coverage in COVERAGES:
        split = coverage_split(capture, coverage, 3)
        inside = np.union1d(split.targets, split.region)
        gaps = np.linalg.norm(capture.centers[:, None] - capture.centers, axis=2)
        nearest = np.argsort(gaps, axis=1)[:, :coverage]
        assert any(np.isin(inside, near).all() for near in nearest)


@pytest.mark.parametrize(("frames", "targets"), [(44, 15), (2, 1)])
def test_too_small_a_capture_is_refused_with_the_counts(frames, targets):
    with pytest.raises(ValueError, match=rf"a test: {frames} frames.* {targets} targets"):
        evaluation_split(random_capture(frames), 0, 0, targets=targets)
    smallest = evaluation_split(random_capture(3 * targets), 0, 0, targets=targets)
    assert len(smallest.proxies) == len(smallest.candidates) == targets


def test_targets_come_from_the_frames_that_may_be_targets():
    capture, among = random_capture(40), np.array([2, 3, 5, 8, 13, 21, 34])
    split = evaluation_split(capture, 1, 0, targets=5, among=among)
    assert set(split.targets) <= set(among)
    assert len(split.candidates) == 30
    with pytest.raises(ValueError, match="7 that may be targets"):
        evaluation_split(capture, 1, 0, targets=8, among=among)


@pytest.mark.parametrize("coverage", [0, 101, -5])
def test_an_impossible_coverage_is_refused(coverage):
    with pytest.raises(ValueError, match=str(coverage)):
        coverage_split(random_capture(60), coverage, 0)


def test_split_survives_its_table():
    parts = Split(np.array([1, 4]), np.array([5, 0]), np.array([2, 3]), np.array([3]))
    table = pd.DataFrame(parts.table(list("abcdef")))
    roles = ["proxy", "target", "candidate", "candidate", "target", "proxy"]
    assert table["role"].tolist() == roles
    assert table["proxy_of"].tolist() == [4, -1, -1, -1, -1, 1]
    again = Split.from_table(table.sample(frac=1, random_state=0))
    for name in ("targets", "proxies", "candidates", "region"):
        np.testing.assert_array_equal(getattr(again, name), getattr(parts, name))


def test_a_table_of_several_splits_says_which_is_which():
    capture = random_capture(70)
    alone = evaluation_split(capture, 0, 0)
    ((head, split),) = splits_in(alone.table(capture.names))
    assert head == {}
    np.testing.assert_array_equal(split.proxies, alone.proxies)
    levels = {p: coverage_split(capture, p, 0) for p in (60, 25)}
    tables = [
        split.table(capture.names) | repeated({"coverage": p}, 70) for p, split in levels.items()
    ]
    read = list(splits_in(stacked(tables)))
    assert [head for head, _ in read] == [{"coverage": 25}, {"coverage": 60}]
    for head, split in read:
        for name in ("targets", "proxies", "candidates", "region"):
            expected = getattr(levels[head["coverage"]], name)
            np.testing.assert_array_equal(getattr(split, name), expected)
