"""Other numbers in fsel: each changes alone, and is compared with the shipped ones."""

from dataclasses import asdict, fields, replace

import numpy as np
import pandas as pd
import pytest
from selection_problems import problem_on, random_capture
from small_captures import ring

from fsel.experiments.fsel_constants import NONE, OTHERS, changes, fsel_constants, variants
from fsel.features import conditioned
from fsel.features.conditioned import SHIPPED, Constants
from fsel.selector import plain, pretrained
from fsel.selector.policies import POLICIES


def test_the_constants_are_those_of_the_compiled_loop():
    for field in fields(Constants):
        assert getattr(SHIPPED, field.name) == getattr(conditioned, field.name.upper())


def test_a_variant_changes_one_number():
    found = list(variants())
    (first, _, rule, constants), *others = found
    assert first == NONE
    assert rule.coefficients == pretrained.method("fsel").scorer.coefficients
    assert constants == SHIPPED
    assert {name for name, *_ in others} == set(OTHERS)
    for name, value, changed, numbers in others:
        shipped = {**rule.coefficients, **asdict(SHIPPED)}
        now = {**changed.coefficients, **asdict(numbers)}
        assert {key for key in now if now[key] != shipped[key]} == {name}
        assert now[name] == value


def test_every_number_is_read():
    """Picks, or their scores, follow each of the numbers."""
    # neighbours on a path lie close enough to share what they look at
    capture = replace(random_capture(60), world_to_camera=ring(60))
    problem, policy = problem_on(capture), POLICIES["fsel"]
    base = None
    for name, value, rule, constants in variants():
        prepared = policy.prepare(problem, constants)
        _, scores = plain.greedy(prepared, rule, 24, constants)
        if base is None:
            base = scores
        else:
            assert not np.array_equal(scores, base), (name, value)


def test_changes_by_hand(tmp_path):
    """Halved, a number loses 1 and 3 dB at K = 5 in two scenes, and nothing at K = 10."""
    rows, paths = [], []
    for scene, lost in (("a", 1.0), ("b", 3.0)):
        for name, value, less in ((NONE, np.nan, 0.0), ("far", 37.5, lost)):
            for k in (5, 10):
                psnr = 20 + k - (less if k == 5 else 0)
                row = {"name": name, "value": value, "draw": 0, "k": k, "psnr": psnr}
                rows.append(row | {"scene": scene})
        table = pd.DataFrame([row for row in rows if row["scene"] == scene])
        paths.append(tmp_path / f"{scene}.parquet")
        table.drop(columns="scene").to_parquet(paths[-1])
    found = changes(pd.DataFrame(rows)).set_index("k")
    assert found["mean"].to_dict() == pytest.approx({0: -1.0, 5: -2.0, 10: 0.0})
    assert found["shipped"].unique().tolist() == [75.0]
    facts = {"embedded": ["D"], "real": [], "reconstructor": "s", "long_side": 32}
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    fsel_constants(
        paths,
        *outputs,
        scenes=["a", "b"],
        budgets=[5, 10],
        facts=facts | {"descriptor": "lab_hog"},
    )
    assert "far & 75 & 37.5 & $-2.00$ & $" in outputs[0].read_text()
