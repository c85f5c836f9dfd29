"""Selection times, and speed against error."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene

from fsel.core.problem import Problem
from fsel.evaluation.figures import new_figure
from fsel.evaluation.sweep import PLAIN
from fsel.experiments.paper.time_quality import timed
from fsel.experiments.studies import speed_error
from fsel.experiments.studies.speed_error import _draw_methods, gaps, method_seconds
from fsel.metrics import METRICS
from fsel.selectors.baselines import METHODS
from fsel.workflow.settings import shipped

ENDINGS = ("tex", "csv", "pdf", "png")
FACTS = {"embedded": ["A"], "real": [], "reconstructor": "splats", "long_side": 32}
APPEARANCE = {"kind": "lab_hog", "weights": None}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors and one draw of targets."""
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.mark.parametrize(("seconds", "runs"), [(0.1, 5), (0.4, 3), (7.0, 1)])
def test_slow_runs_are_repeated_less(monkeypatch, seconds, runs):
    clock = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    calls = []

    def run():
        clock[0] += seconds
        calls.append(seconds)

    assert timed(run) == pytest.approx(seconds)
    assert len(calls) == runs


def test_every_method_is_timed_and_only_readers_pay_for_descriptors(scene):
    problem = Problem.load(scene, scene / "split.parquet")
    table = method_seconds(problem, [shipped("fsel")], 6, APPEARANCE)
    assert set(table.index) == set(METHODS) - {"all"} | {"fsel"}
    assert (table["selection"] > 0).all()
    reads = [name in METHODS and bool(METHODS[name].reads) for name in table.index]
    np.testing.assert_array_equal(table["descriptors"] > 0, reads)
    np.testing.assert_allclose(table["seconds"], table["descriptors"] + table["selection"])


def test_the_gap_to_the_search_by_hand():
    rows = [("a", "s0", 0, 20.0, 18.0), ("a", "s0", 1, 22.0, 18.0), ("a", "s1", 0, 21.0, 20.0)]
    rows += [("b", "s0", 0, 25.0, 25.5), ("b", "s0", 1, None, 1.0)]
    cells = pd.DataFrame(rows, columns=["dataset", "scene", "draw", "search", "fvs"])
    cells = cells.melt(["dataset", "scene", "draw"], var_name="method", value_name="psnr").dropna()
    # dataset a: mean of 3 and 1; dataset b: -0.5, the draw without a search left out
    found = gaps(cells, reference="search", methods=["fvs"])
    assert found.to_dict("records") == [{"method": "fvs", "gap": 0.75}]
    with pytest.raises(ValueError, match=r"no PSNR of 'search' .* Hint: set oracle.draws"):
        gaps(cells[cells["method"] == "fvs"], reference="search", methods=["fvs"])


def side(start, end, point):
    """On which side of the line through two points a point lies: the sign of a cross product."""
    (x, y), (u, v) = end - start, point - start
    return np.sign(x * v - y * u)


@pytest.mark.parametrize("seed", range(4))
def test_no_two_lines_from_points_to_names_cross(seed):
    rng, n = np.random.default_rng(seed), len(PLAIN)
    seconds, gap = 10 ** rng.uniform(-4, 0, n), rng.uniform(-0.2, 5, n)
    seconds[:9], gap[:9] = rng.uniform(0.08, 0.1, 9), rng.uniform(0.4, 1, 9)  # most are alike
    figure = new_figure((3.4, 3.6))
    axis = figure.subplots(subplot_kw={"xscale": "log"})
    _draw_methods(axis, pd.DataFrame({"method": list(PLAIN), "seconds": seconds, "gap": gap}))
    figure.canvas.draw()
    at = [axis.transData.transform(name.xy) for name in axis.texts]
    led = [axis.transAxes.transform(name.xyann) for name in axis.texts]
    lines = list(zip(at, led, strict=True))
    assert len(lines) == n
    for one, other in combinations(lines, 2):
        apart = side(*one, other[0]) == side(*one, other[1])
        assert apart or side(*other, one[0]) == side(*other, one[1])


def test_speed_and_error_of_equal_numbers_are_equal_bytes(scene, tmp_path, monkeypatch):
    times = {"descriptors": 0.1, "selection": [0.2, 0.001], "seconds": [0.3, 0.101]}
    times = pd.DataFrame(times, index=["fvs", "random"])
    monkeypatch.setattr(speed_error, "method_seconds", lambda *_: times)
    tables = {"evaluation": {"fvs": [20, 21], "random": [18, 18]}, "oracle": {"search": [22, 23]}}
    for name, values in tables.items():
        rows = [(m, 0, 10, t, v, 0.5, 0.1) for m, vs in values.items() for t, v in enumerate(vs)]
        table = pd.DataFrame(rows, columns=["method", "seed", "k", "target", *METRICS])
        table.to_parquet(tmp_path / f"{name}.parquet")
    read = [scene, scene / "split.parquet", []]
    read += [[tmp_path / f"{name}.parquet"] for name in tables]
    for name in "ab":
        table, numbers, *figures = (tmp_path / f"{name}.{ending}" for ending in ENDINGS)
        asked = {"problems": ["d/s/draw0"], "k": 10, "appearance": APPEARANCE, "facts": FACTS}
        speed_error.speed_error(*read, table, numbers, figures, **asked)
    for ending in ENDINGS:
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in "ab")
        assert first == second
    text = (tmp_path / "a.tex").read_text()
    assert "FVS & 300 & 2.00" in text
    assert "10 of 36 frames" in text
    assert pd.read_csv(tmp_path / "a.csv").set_index("method").loc["fvs", "selection"] == 0.2
