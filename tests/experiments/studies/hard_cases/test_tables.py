"""The tables of hard cases and of arithmetic."""

import numpy as np
import pandas as pd
import pytest

from fsel.evaluation.evaluator import Evaluator
from fsel.experiments.studies import precision, stability
from fsel.experiments.studies.hard_cases import CASES, Case, Finding
from fsel.experiments.studies.hard_cases.problems import UTM
from fsel.experiments.studies.hard_cases.worlds import moved, random_weights, world
from fsel.reconstruct.splats import Splats
from fsel.selectors import pretrained
from fsel.selectors.scorer import Network


def raises():
    raise ValueError("no such frame")


def test_a_row_for_every_case_and_faults_are_told(tmp_path, monkeypatch):
    cases = [
        Case("good", "50% of x_1", lambda: Finding("2 of 4", 1e-12, 1e-9)),
        Case("wrong", "two", lambda: Finding("three", 1.0, 1e-9)),
        Case("broken", "three", raises),
    ]
    monkeypatch.setattr(stability, "CASES", {case.name: case for case in cases})
    stability.stability(tmp_path / "s.tex", tmp_path / "s.csv")
    table = pd.read_csv(tmp_path / "s.csv")
    assert table["holds"].tolist() == [True, False, False]
    assert table["observed"].tolist() == ["2 of 4", "three", "ValueError: no such frame"]
    text = (tmp_path / "s.tex").read_text()
    assert "1 of 3 hold" in text
    assert r"good & 50\% of x\_1 & 2 of 4 & 1.0e-12 & 1e-09 \\" in text


def test_single_precision_is_single_throughout(monkeypatch):
    problem, seen = world(), []

    def spy(prepared, scorer, k):
        *arrays, visible, _ = prepared.rows
        arrays.append(visible.seen)
        seen.append({prepared.static.dtype, *(array.dtype for array in arrays if array.size)})
        return np.arange(k), np.zeros(k)

    monkeypatch.setattr(precision.plain, "greedy", spy)
    precision.selections(problem, "fsel", pretrained.method().scorer, 4)
    assert seen == [{np.dtype(np.float64)}, {np.dtype(np.float32)}]


def test_single_precision_loses_millimetres_in_utm_and_the_kernel_does_not():
    problem = moved(world(), np.eye(3), UTM, 1e-3)
    found = precision.selections(problem, "less_is_more", Network(random_weights(0)), 8)
    picks = {name: frames for name, (frames, _) in found.items()}
    np.testing.assert_array_equal(picks["kernel"], picks["float64"])
    assert precision.agreement(picks["float32"], picks["float64"]) < 1


def test_agreement_forgets_the_order():
    assert precision.agreement(np.array([3, 1, 2, 9]), np.array([1, 2, 3, 4])) == 0.75


def test_every_arithmetic_is_measured_against_float64():
    problem = world()
    evaluate = Evaluator.on_frames(Splats(problem.capture), problem.proxies)
    rows = precision.compare_arithmetic(
        problem, {"less_is_more": Network(random_weights(0))}, 6, evaluate
    )
    assert [row["arithmetic"] for row in rows] == ["float64", "float32", "kernel"]
    assert rows[0]["agreement"] == rows[2]["agreement"] == 1
    picks = precision.selections(problem, "less_is_more", Network(random_weights(0)), 6)["float64"][
        0
    ]
    assert rows[0]["psnr"] == pytest.approx(evaluate(picks)[0])
    assert rows[0]["psnr_change"] == rows[2]["psnr_change"] == 0
    assert all(row["seconds"] > 0 for row in rows)


def test_the_loss_gap_by_hand():
    rows = [("train epoch 0", "float64", 2.0), ("train epoch 0", "float32", 2.0)]
    rows += [("train epoch 1", "float64", 1.0), ("train epoch 1", "float32", 0.98)]
    curves = pd.DataFrame(rows, columns=["name", "arithmetic", "loss"]).assign(part="loss")
    other = pd.DataFrame({"name": ["s"], "arithmetic": ["float32"], "part": ["Hard cases"]})
    assert precision.loss_gap(pd.concat([curves, other])) == pytest.approx(0.02)


def test_hard_cases_with_cameras_offer_their_problem():
    assert sum(case.make is not None for case in CASES.values()) >= 16
