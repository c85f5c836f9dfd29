"""The static features: against a slow twin, and at degenerate poses."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, in_line, moved, problem_of, random_problem
from slow_selector import angle

from fsel.core.files import read_table, write_table
from fsel.features.columns import CONDITIONED, FEATURES, STATIC
from fsel.features.static import SIGNS, UNITS, features_table, static_features, with_features
from fsel.selectors.policies import KNOWN


def proxies_of(problem):
    return problem.capture.view(problem.proxies)


def slow_features(problem, pool, views):
    """Appendix A.1 word by word: one candidate, one view at a time."""
    capture = problem.capture
    centroid = np.mean([capture.centers[i] for i in problem.candidates], axis=0)
    points = []
    for center, axis in zip(views.centers, views.axes, strict=True):
        points.append(center + max(0.0, (centroid - center) @ axis) * axis)
    rows = []
    for i in pool:
        center, axis = capture.centers[i], capture.axes[i]
        distance, turn, tri, across, along, seen = [], [], [], [], [], []
        for view, look, point in zip(views.centers, views.axes, points, strict=True):
            distance.append(np.linalg.norm(center - view))
            turn.append(angle(axis, look))
            tri.append(angle(center - point, view - point) if (view != point).any() else np.pi / 2)
            along.append((center - view) @ look)
            across.append(np.linalg.norm(np.cross(center - view, look)))
            seen.append(angle(point - center, axis) <= capture.views.half_fov[i])
        rho = [
            float(problem.descriptors[i].astype(float) @ problem.descriptors[o])
            for o in problem.proxies
        ]
        degrees = np.degrees(tri)
        score = [np.exp(-((d - 5) ** 2) / (2 * (1 if d <= 5 else 10) ** 2)) for d in degrees]
        rows.append([
            min(distance), np.mean(distance), np.percentile(distance, 25), min(turn),
            np.mean(turn), max(rho), np.mean(rho), np.std(rho), max(score), np.mean(tri),
            np.mean(across), np.mean(along), np.mean(seen), problem.sharpness[i],
        ])  # fmt: skip
    return np.array(rows)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("reference", ["proxies", "targets"])
def test_features_against_the_slow_twin(seed, reference):
    problem = random_problem(25, seed)
    views = problem.targets if reference == "targets" else proxies_of(problem)
    pool = problem.candidates
    np.testing.assert_allclose(
        static_features(problem, pool, views), slow_features(problem, pool, views), atol=1e-9
    )


def test_names_and_signs_are_the_papers():
    assert len(STATIC) == 14
    assert len(FEATURES) == 18
    assert FEATURES[13:17] == CONDITIONED
    assert (FEATURES[0], FEATURES[-1]) == ("d_min_o", "sharpness")
    assert tuple(SIGNS) == FEATURES
    assert SIGNS["d_min_o"] == SIGNS["gamma_mean_o"] == SIGNS["rho_max_s"] == -1
    assert SIGNS["d_min_s"] == SIGNS["rho_max_o"] == SIGNS["sharpness"] == 1


def test_without_appearance_no_descriptor_is_read():
    problem = random_problem(20)
    blind = replace(problem, descriptors=np.full((20, 3), np.nan, np.float32))
    table = static_features(blind, problem.candidates, proxies_of(problem), appearance=False)
    full = static_features(problem, problem.candidates, proxies_of(problem))
    np.testing.assert_array_equal(table[:, 5:8], 0)
    np.testing.assert_array_equal(np.delete(table, [5, 6, 7], 1), np.delete(full, [5, 6, 7], 1))


def test_cameras_in_one_place_have_finite_features():
    problem = problem_of(in_line(np.zeros(12)), [3, 4], np.arange(5, 12), np.arange(3))
    assert np.isfinite(static_features(problem, problem.observed, problem.targets)).all()


def test_a_candidate_on_a_reference_point_has_finite_features():
    """A proxy at (0, 0, -10) looks along z, past a candidate at the origin and one beside it."""
    line = np.array([[0, 0, -10], [0, 0, -10.5], [0, 0, 0], [0, 1e-50, 0]])
    there = problem_of(capture_of(line, np.tile(np.eye(3), (4, 1, 1))), [0], [2, 3], [1])
    assert np.isfinite(static_features(there, there.observed, proxies_of(there))).all()


def test_a_moved_and_scaled_world_scales_lengths_and_nothing_else():
    problem = random_problem(30, seed=1)
    rotation = Rotation.random(rng=np.random.default_rng(0)).as_matrix()
    other = moved(problem, rotation, np.array([3.0, -2, 7]), 2.5)
    lengths = np.isin(STATIC, ["d_min_o", "d_mean_o", "d_p25_o", "b_perp", "b_par"])
    before = static_features(problem, problem.candidates, proxies_of(problem))
    after = static_features(other, other.candidates, proxies_of(other))
    np.testing.assert_allclose(after, before * np.where(lengths, 2.5, 1), atol=1e-9)


def stored(problem, folder):
    path = folder / "features.parquet"
    write_table(features_table(problem), path, units=UNITS, config="c")
    return read_table(path)


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
        (lambda t: t[1:], "21 rows for 22 candidates"),
        (lambda t: t.assign(frame=t["frame"] + 1), "22 rows for 22 candidates"),
        (lambda t: t.assign(tau_tri=np.nan), "tau_tri of frame .* is nan"),
    ],
)
def test_features_of_another_problem_are_refused(change, said):
    problem = random_problem(30)
    with pytest.raises(ValueError, match=f"old.parquet: .*{said}"):
        with_features(problem, change(pd.DataFrame(features_table(problem))), "old.parquet")
