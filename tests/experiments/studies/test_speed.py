"""Selection times, and speed against error."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from described_scene import write_scene
from selection_problems import random_capture, random_problem, with_points

from fsel.evaluation.figures import new_figure
from fsel.evaluation.sweep import PLAIN
from fsel.experiments.studies.selection_time import problem_of_size, refilmed, selection_time, timed
from fsel.experiments.studies.speed_error import _draw_methods, gaps, speed_error
from fsel.metrics import METRICS
from fsel.selectors.baselines import METHODS

ENDINGS = ("tex", "csv", "pdf", "png")
FACTS = {"embedded": ["A"], "real": [], "reconstructor": "splats", "long_side": 32}
APPEARANCE = {"kind": "lab_hog", "weights": None}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors and one draw of targets."""
    return write_scene(tmp_path_factory.mktemp("scene"))


def test_a_path_at_twice_the_rate_has_its_frames_and_their_midpoints():
    capture = random_capture(6)
    dense, old = refilmed(capture, 11)
    np.testing.assert_allclose(dense.world_to_camera[::2], capture.world_to_camera, atol=1e-12)
    middle = (capture.centers[1:] + capture.centers[:-1]) / 2
    np.testing.assert_allclose(dense.centers[1::2], middle, atol=1e-12)
    rotation, turns = dense.world_to_camera[1::2, :, :3], capture.world_to_camera[:, :, :3]
    # halfway between two rotations is as far from one as from the other
    ends = (np.linalg.norm(rotation - end, axis=(1, 2)) for end in (turns[:-1], turns[1:]))
    np.testing.assert_allclose(*ends)
    np.testing.assert_array_equal(old[::2], np.arange(6))
    np.testing.assert_array_equal(dense.images[[0, 4, 10]], capture.images[[0, 2, 5]])


def test_a_new_frame_sees_what_its_old_one_saw():
    capture = with_points(random_problem(12)).capture
    points = capture.points
    dense, old = refilmed(capture, 20)
    for frame in range(20):
        seen = dense.points.track_point[dense.points.track_frame == frame]
        expected = points.track_point[points.track_frame == old[frame]]
        np.testing.assert_array_equal(np.sort(seen), np.sort(expected))


@pytest.mark.parametrize("pool", [12, 40, 300])
def test_a_problem_has_the_asked_pool(pool):
    rng = np.random.default_rng(0)
    described = rng.random((30, 3)).astype(np.float32), rng.random(30)
    problem = problem_of_size(random_capture(30), *described, pool=pool, targets=4)
    assert len(problem.observed) == pool
    assert len(problem.targets) == len(problem.proxies) == 4
    assert len(problem.descriptors) == len(problem.sharpness) == pool + 4


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


def test_every_method_is_timed_and_only_readers_pay_for_descriptors(scene, tmp_path):
    paths = [tmp_path / "t.tex", tmp_path / "t.csv"]
    sizes = {"pools": [30, 20], "k": 6, "targets": 4}
    selection_time(scene, [], *paths, **sizes, appearance=APPEARANCE)
    table = pd.read_csv(paths[1])
    assert table["pool"].unique().tolist() == [20, 30]
    assert set(table["method"]) == set(METHODS) - {"all"}
    assert (table["selection"] > 0).all()
    for method, part in table.groupby("method"):
        assert (part["descriptors"] > 0).all() == bool(METHODS[method].reads)
    of_dpp = table[table["method"] == "dpp"].set_index("pool")["descriptors"]
    assert of_dpp[30] == pytest.approx(1.5 * of_dpp[20], rel=1e-2)
    text = paths[0].read_text()
    assert "20 frames & 30 frames" in text
    assert text.count(" + ") == 2 * sum(bool(METHODS[name].reads) for name in set(table["method"]))


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


def test_speed_and_error_of_equal_numbers_are_equal_bytes(tmp_path):
    times = pd.DataFrame({"method": ["fvs", "random", "fvs"], "k": 30, "pool": [130, 130, 1000]})
    times.assign(descriptors=0.1, selection=[0.2, 0.001, 9]).to_csv(tmp_path / "t.csv")
    tables = {"evaluation": {"fvs": [20, 21], "random": [18, 18]}, "oracle": {"search": [22, 23]}}
    for name, values in tables.items():
        rows = [(m, 0, 10, t, v, 0.5, 0.1) for m, vs in values.items() for t, v in enumerate(vs)]
        table = pd.DataFrame(rows, columns=["method", "seed", "k", "target", *METRICS])
        table.to_parquet(tmp_path / f"{name}.parquet")
    read = [[tmp_path / f"{name}.parquet"] for name in tables]
    for name in "ab":
        table, numbers, *figures = (tmp_path / f"{name}.{ending}" for ending in ENDINGS)
        made = table, numbers, figures
        asked = {"problems": ["d/s/draw0"], "k": 10, "facts": FACTS}
        speed_error(tmp_path / "t.csv", *read, *made, **asked)
    for ending in ENDINGS:
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in "ab")
        assert first == second
    text = (tmp_path / "a.tex").read_text()
    assert "FVS & 300 & 2.00" in text
    assert len(pd.read_csv(tmp_path / "a.csv")) == 2
