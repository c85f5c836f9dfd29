"""Labels for requests: what is asked, where swaps begin, what is kept."""

import numpy as np
import pandas as pd
from selection_problems import random_problem

from fsel.baselines.nearest import nearest
from fsel.selector import pretrained
from fsel.training.requests import most_subsets, requests_of, search_request, starts

SEARCH = {"evaluations": 30, "exchanged": 2, "generations": 0}


def test_every_level_of_every_draw_is_asked_and_a_draw_more_changes_none():
    asked = requests_of([25, 100], 3, [10, 20, 50], 7)
    assert [(r.draw, r.coverage) for r in asked] == [(d, c) for d in range(3) for c in (25, 100)]
    assert {r.k for r in asked} <= {10, 20, 50}
    assert requests_of([25, 100], 2, [10, 20, 50], 7) == asked[:4]
    assert len({r.k for r in requests_of([60], 40, [10, 20, 50], 7)}) == 3


def test_starts_are_the_rule_nearest_and_a_third_exchanged():
    problem, rng = random_problem(40), np.random.default_rng(0)
    found = starts(problem, 9, 2, rng)
    assert [name for name, _ in found] == ["fsel", "nearest", "exchanged", "exchanged"]
    rule = pretrained.method("fsel").select(problem, 9, rng)
    np.testing.assert_array_equal(found[0][1], rule)
    np.testing.assert_array_equal(found[1][1], nearest(problem, problem.observed, 9))
    for _, picks in found[2:]:
        assert len(np.unique(picks)) == 9
        assert len(np.intersect1d(picks, rule)) == 6
        assert np.isin(picks, problem.observed).all()
    assert found[2][1].tolist() != found[3][1].tolist()


def searched(judge, evaluations=30, seed=0):
    problem = random_problem(40)
    rng = np.random.default_rng(seed)
    settings = SEARCH | {"evaluations": evaluations}
    return problem, search_request(judge, problem, 6, settings, rng)


def test_a_search_keeps_good_and_bad_subsets_each_judged_once():
    asked = []

    def judge(subset):
        asked.append(subset.tolist())
        return float(subset.sum())

    problem, table = searched(judge)
    assert table["subset"].tolist() == asked
    assert len(table) == len({tuple(s) for s in asked}) == 30
    assert all(s == sorted(s) and np.isin(s, problem.observed).all() for s in asked)
    np.testing.assert_array_equal(table["psnr"], [sum(s) for s in asked])
    assert table["start"].unique().tolist() == ["fsel", "nearest", "exchanged"]
    # a quarter of the evaluations to each of the four starts, two of which share a name
    assert table["start"].value_counts()[["fsel", "nearest"]].between(7, 8).all()
    ranked = table.sort_values("rank")
    assert ranked["psnr"].is_monotonic_decreasing
    assert ranked["rank"].tolist() == list(range(30))
    assert table["psnr"].max() > table["psnr"].iloc[0] > table["psnr"].min()


def test_a_search_is_repeated_exactly_and_ends_where_starts_alone_fill_it():
    first, again = (searched(lambda s: float(s.sum()))[1] for _ in range(2))
    pd.testing.assert_frame_equal(first, again)
    assert len(searched(lambda s: 0.0, evaluations=1)[1]) == 4


def test_the_paper_s_search_follows_the_swaps_and_changes_none():
    problem, rng = random_problem(40), np.random.default_rng(0)
    found = search_request(lambda s: float(s.sum()), problem, 6, SEARCH | {"generations": 2}, rng)
    _, swapped = searched(lambda s: float(s.sum()))
    columns = ["start", "subset", "psnr"]
    pd.testing.assert_frame_equal(found[columns][:30], swapped[columns])
    assert found["start"][30:].unique().tolist() == ["genetic"]
    assert len({tuple(subset) for subset in found["subset"]}) == len(found)
    # 40 of the first generation and 38 children in each other, but for those that were met before
    assert 80 < len(found) - 30 <= 116
    assert [most_subsets(SEARCH | {"generations": n}) for n in (0, 2)] == [30, 150]
    assert found["psnr"].iloc[30:].max() > found["psnr"].iloc[30:70].max()
