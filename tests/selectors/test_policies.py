"""What a policy sees."""

import numpy as np
from selection_problems import random_problem

from fsel.features.columns import APPEARANCE, NAMES, SHARPNESS, positions
from fsel.selectors.policies import GEOMETRY, POLICIES


def test_inputs_that_a_policy_does_not_read_are_zero_and_the_others_as_they_are():
    problem = random_problem(40)
    full, few = (p.prepare(problem).static for p in (POLICIES["less_is_more"], GEOMETRY))
    gone = positions((*APPEARANCE, SHARPNESS))
    assert full[:, gone[:-2]].any(axis=0).all()
    assert full[:, gone[-1]].any()
    assert not few[:, gone].any()
    kept = np.setdiff1d(np.arange(len(NAMES)), gone)
    np.testing.assert_array_equal(few[:, kept], full[:, kept])


def test_what_is_not_read_need_not_be_measured():
    assert POLICIES["less_is_more"].reads == ("appearance", SHARPNESS)
    assert POLICIES["less_is_more_no_appearance"].reads == (SHARPNESS,)
    assert GEOMETRY.reads == POLICIES["fsel"].reads == ()
