"""Features on disk: what comes back is what was computed, bit for bit, or is refused."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from selection_problems import random_problem

from fsel.core.files import read_table, write_table
from fsel.features.columns import STATIC
from fsel.features.static import UNITS, static_features
from fsel.features.table import features_table, with_features
from fsel.selectors.policies import KNOWN


def stored(problem, folder):
    path = folder / "features.parquet"
    write_table(features_table(problem), path, units=UNITS, config="c")
    return read_table(path)


def test_a_row_a_candidate_with_its_name(tmp_path):
    problem = random_problem(30)
    table = stored(problem, tmp_path)
    assert list(table) == ["frame", "name", *STATIC]
    np.testing.assert_array_equal(table["frame"], problem.candidates)
    assert table["name"].tolist() == [problem.capture.names[i] for i in problem.candidates]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["less_is_more", "less_is_more_no_appearance"])
def test_a_policy_is_shown_the_same_bits_from_the_file(name, seed, tmp_path):
    problem = random_problem(30, seed)
    table = stored(problem, tmp_path).sample(frac=1, random_state=seed)
    known = with_features(problem, table, "f")
    computed = static_features(problem, problem.candidates, problem.capture.view(problem.proxies))
    np.testing.assert_array_equal(known.features, computed)
    first, second = KNOWN[name].prepare(problem), KNOWN[name].prepare(known)
    assert first.static.tobytes() == second.static.tobytes()


def test_the_file_is_what_is_read_where_pool_and_references_are_its_own():
    problem = replace(random_problem(30), features=np.zeros((22, len(STATIC))))
    policy = KNOWN["less_is_more"]
    assert not policy.prepare(problem).static.any()
    for other in (replace(policy, reference="targets"), replace(policy, pool="observed")):
        assert other.prepare(problem).static.any()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t[1:], "21 rows are not one for each of the problem's 22 candidates"),
        (lambda t: t.assign(frame=t["frame"] + 1), "made for another split"),
        (lambda t: t.drop(columns="b_par"), "no column b_par"),
        (lambda t: t.assign(tau_tri=np.nan), "tau_tri of frame .* is nan"),
    ],
)
def test_features_of_another_problem_are_refused(change, said):
    problem = random_problem(30)
    with pytest.raises(ValueError, match=f"old.parquet: .*{said}"):
        with_features(problem, change(pd.DataFrame(features_table(problem))), "old.parquet")
