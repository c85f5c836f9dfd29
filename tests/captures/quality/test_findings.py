"""Which bad frames are left out, and what findings say."""

import numpy as np

from fsel.captures.quality.findings import (
    BLURRED,
    DUPLICATE,
    EXPOSED,
    MISPLACED,
    Finding,
    Health,
    exceeding,
    left_out,
)


def found(**severity):
    kinds = {"b": BLURRED, "m": MISPLACED, "d": DUPLICATE, "e": EXPOSED}
    return tuple(
        Finding(int(name[1:]), kinds[name[0]], 2.0 * value, 2.0, "times")
        for name, value in severity.items()
    )


def everything(frame, staying):
    return True


def test_all_that_others_show_is_left_out_the_worst_last():
    findings = found(b1=3.0, b2=1.5, e2=1.2, m4=1.1, d5=0.1, b6=9.0)
    assert [part.tolist() for part in left_out(findings, 8, everything)] == [[2, 1, 6, 4], []]
    assert [part.tolist() for part in left_out((), 8, everything)] == [[], []]


def test_the_least_bad_of_a_stretch_stays_and_a_misplaced_frame_never():
    part = {2, 3, 4}  # of the scene, which these frames alone show

    def shown(frame, staying):
        return frame not in part or any(staying[other] for other in part)

    findings = found(b2=3.0, b3=1.5, b4=2.0, b7=5.0)
    assert [part.tolist() for part in left_out(findings, 8, shown)] == [[4, 2, 7], [3]]
    findings = found(m2=1.2, m3=1.5, m4=2.0)
    assert [part.tolist() for part in left_out(findings, 8, shown)] == [[2, 3, 4], []]


def test_no_more_than_so_many_are_left_out():
    health = Health(found(b1=3.0, b2=1.5), None, np.array([2, 1]))
    assert health.leaving_out(np.arange(9), 9).left_out.tolist() == [2, 1]
    assert health.leaving_out(np.arange(9), 1).left_out.tolist() == [1]
    assert health.leaving_out(np.arange(9), 0).left_out.tolist() == []
    assert health.leaving_out(np.array([2, 5]), 9).left_out.tolist() == [2]
    assert health.of_kind(BLURRED).tolist() == [1, 2]
    assert health.of(2) == [health.findings[1]]


def test_a_finding_says_how_much_and_what_is_allowed():
    one, two = exceeding(BLURRED, np.array([0.2, 0.75, np.nan, 0.9]), 0.5, "times less detail")
    assert str(one) == "blurred: 0.75 times less detail, at most 0.5"
    assert (two.frame, two.severity) == (3, 1.8)
    assert "at least 2" in str(found(d1=0.5)[0])
    assert Finding(0, "unreadable", 1.0, 0.0, "image").severity == float("inf")
