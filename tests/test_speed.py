"""Selection times, the figure of speed against quality, and the sweep of FisherRF's lambda."""

import numpy as np
import pandas as pd
import pytest
from selection_problems import random_capture, random_problem, with_points

from fsel.baselines import METHODS
from fsel.baselines.fisher_rf import SWEEP
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.metrics import METRICS
from fsel.pipeline.damping import damping_sweep
from fsel.pipeline.descriptions import describe
from fsel.pipeline.labels import reconstructor_of
from fsel.pipeline.problems import load_problem, split, split_from
from fsel.pipeline.timing import problem_of_size, refilmed, selection_time, speed_figure, timed
from fsel.report.latex import plain_table
from fsel.report.speed import gaps
from fsel.synthesis import record

RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
APPEARANCE = {"kind": "lab_hog", "weights": None}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors and one draw of targets."""
    folder = tmp_path_factory.mktemp("scene")
    made = record("dl3dv", 3, frames=40, width=32, height=24)
    focal = made.camera.params[0]
    camera = np.tile([focal, focal, 16.0, 12.0], (40, 1))
    Capture(made.names, made.world_to_camera, camera, made.images, made.sequences).save(folder)
    describe(folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    split(folder, [folder / "split.parquet"], targets=4, seed=1, config="c")
    return folder


def test_a_path_at_twice_the_rate_has_its_frames_and_their_midpoints():
    capture = random_capture(6)
    dense, old = refilmed(capture, 11)
    np.testing.assert_allclose(dense.world_to_camera[::2], capture.world_to_camera, atol=1e-12)
    middle = (capture.centers[1:] + capture.centers[:-1]) / 2
    np.testing.assert_allclose(dense.centers[1::2], middle, atol=1e-12)
    rotation = dense.world_to_camera[1::2, :, :3]
    # halfway between two rotations is as far from one as from the other
    gaps_to = [
        np.linalg.norm(rotation - capture.world_to_camera[side, :, :3], axis=(1, 2))
        for side in (slice(None, -1), slice(1, None))
    ]
    np.testing.assert_allclose(*gaps_to)
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


def described(n):
    rng = np.random.default_rng(0)
    return random_capture(n), rng.random((n, 3)).astype(np.float32), rng.random(n)


@pytest.mark.parametrize("pool", [12, 40, 300])
def test_a_problem_has_the_asked_pool(pool):
    problem = problem_of_size(*described(30), pool=pool, targets=4)
    assert len(problem.observed) == pool
    assert len(problem.targets) == len(problem.proxies) == 4
    assert len(problem.descriptors) == len(problem.sharpness) == pool + 4


@pytest.mark.parametrize(("seconds", "runs"), [(0.1, 5), (0.4, 3), (7.0, 1)])
def test_slow_runs_are_repeated_less(monkeypatch, seconds, runs):
    clock = [0.0]
    monkeypatch.setattr("fsel.pipeline.timing.time.perf_counter", lambda: clock[0])
    calls = []

    def run():
        clock[0] += seconds
        calls.append(seconds)

    assert timed(run) == pytest.approx(seconds)
    assert len(calls) == runs


def test_every_method_is_timed_and_only_readers_pay_for_descriptors(scene, tmp_path):
    paths = [tmp_path / "t.tex", tmp_path / "t.csv"]
    sizes = {"pools": [30, 20], "k": 6, "targets": 4}
    selection_time(scene, {}, *paths, **sizes, appearance=APPEARANCE)
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


def evaluation_of(values):
    """method -> PSNR of two targets, as an evaluation table at K = 10."""
    rows = [(m, 0, 10, t, v, 0.5, 0.1) for m, vs in values.items() for t, v in enumerate(vs)]
    return pd.DataFrame(rows, columns=["method", "seed", "k", "target", *METRICS])


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


def test_the_figure_of_equal_numbers_is_equal_bytes(tmp_path):
    times = pd.DataFrame({"method": ["fvs", "random", "fvs"], "k": 30, "pool": [130, 130, 1000]})
    times.assign(descriptors=0.1, selection=[0.2, 0.001, 9]).to_csv(tmp_path / "t.csv")
    tables = {"evaluation": {"fvs": [20, 21], "random": [18, 18]}, "oracle": {"search": [22, 23]}}
    items = []
    for name, values in tables.items():
        evaluation_of(values).to_parquet(tmp_path / f"{name}.parquet")
        path = tmp_path / f"{name}.parquet"
        items.append({"dataset": "d", "scene": "s", "draw": "draw0", "path": path})
    for name in "ab":
        outputs = [tmp_path / f"{name}.pdf", tmp_path / f"{name}.png"]
        speed_figure(tmp_path / "t.csv", items, outputs, k=10)
    for ending in ("pdf", "png"):
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in "ab")
        assert first == second


def test_the_default_lambda_of_the_sweep_is_the_comparisons_fisherrf(scene, tmp_path):
    problems = [{"dataset": "d", "folder": scene, "split": scene / "split.parquet"}]
    paths = [tmp_path / "f.tex", tmp_path / "f.csv"]
    damping_sweep(problems, *paths, budgets=[6, 12], reconstruction=RECONSTRUCTION)
    table = pd.read_csv(paths[1])
    assert table["damping"].unique().tolist() == list(SWEEP)
    problem = load_problem(scene, scene / "split.parquet")
    targets = split_from(pd.read_parquet(scene / "split.parquet")).targets
    evaluate = Evaluator.on_frames(reconstructor_of(problem.capture, RECONSTRUCTION), targets)
    picks = METHODS["fisher_rf"].select(problem, 12, np.random.default_rng(0))
    found = table[table["damping"] == SWEEP[0]].set_index("k")["psnr"]
    assert found[12] == pytest.approx(evaluate(picks)[0], abs=1e-6)
    assert found[6] == pytest.approx(evaluate(picks[:6])[0], abs=1e-6)
    assert f"$10^{{-6}}$ & {found[6]:.2f} & {found[12]:.2f}" in paths[0].read_text()


def test_a_plain_table():
    text = plain_table(["a", "b"], [["x", "1"], ["y", "2"]], caption="C", label="l")
    assert r"\begin{tabular}{lr}" in text
    assert "a & b \\\\\n\\midrule\nx & 1 \\\\\ny & 2 \\\\\n\\bottomrule" in text
