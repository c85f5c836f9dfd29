"""Two sources of poses: what is paired, what is compared."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pose_program
import pytest
from described_scene import filmed, save_described
from evaluation_files import FACTS
from small_sweep import run_trials

from fsel.captures.images import files as image_files
from fsel.core.capture import Capture
from fsel.core.files import write_table
from fsel.evaluation.summary import read_csv
from fsel.experiments.paper.pose_sources import TRIALS, pair_poses, pose_sources


def evaluation(path, given, other):
    """Ours and Uniform at K = 10, one target."""
    rows = [
        (0, source, method, 0, 10, 3, psnr - less)
        for source, psnr in (("given", given), ("other", other))
        for method, less in (("less_is_more", 0), ("uniform", 1))
    ]
    columns = ["draw", "source", "method", "seed", "k", "target", "psnr"]
    write_table(pd.DataFrame(rows, columns=columns), path, units={}, config="c")
    return path


def test_both_sources_are_means_and_their_difference_is_paired(tmp_path):
    paths = [evaluation(tmp_path / "a", 22, 21.5), evaluation(tmp_path / "b", 24, 23.0)]
    asked = {"scenes": [("mine", "a"), ("mine", "b")], "names": ["COLMAP", "VGGT"]}
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    pose_sources(paths, *outputs, budgets=[10], metrics=["psnr"], facts=FACTS, **asked)
    found = read_csv(tmp_path / "t.csv").set_index(["method", "source"])["mean"]
    assert found["less_is_more", "given"] == 23
    assert found["less_is_more", "other"] == 22.25
    assert found["less_is_more", "difference"] == -0.75
    assert found["uniform", "given"] == 22
    row = next(line for line in outputs[0].read_text().splitlines() if line.startswith("10 & "))
    assert [cell.strip() for cell in row.split("&")][1:3] == ["23.00", "22.25"]
    assert row.count("-0.75") == 1
    assert pytest.approx(found["uniform", "difference"]) == -0.75


def test_equal_poses_make_no_difference_whatever_their_world(tmp_path):
    capture, settings = filmed(24), {"draws": 1, "targets": 3, "budgets": [4]}
    given = save_described(capture, tmp_path / "given")
    # turned, shifted and scaled
    turned = capture.world_to_camera[:, :, :3] @ np.array([(0.0, 0, 1), (1, 0, 0), (0, 1, 0)]).T
    shift = 3 * capture.world_to_camera[:, :, 3] - turned @ np.array([1.0, -2, 0.5])
    poses = np.concatenate([turned, shift[..., None]], axis=2)
    replace(capture, world_to_camera=poses).save(tmp_path / "other")
    settings |= {"seed": 1, "split_seed": 2}
    _, table = run_trials(TRIALS, [given, tmp_path / "other"], tmp_path, settings=settings)
    psnr = table.groupby(["source", "method", "seed"])["psnr"].mean()
    assert len(psnr.loc["given"]) > 16
    np.testing.assert_allclose(psnr.loc["other"], psnr.loc["given"], atol=0.02)


def test_two_programs_are_compared_on_the_frames_that_both_place(tmp_path):
    photos, kept = tmp_path / "photos", {"long_side": 32, "at_least": 3, "model": "none"}
    image_files.write(np.full((6, 48, 64, 3), 99, np.uint8), photos, [f"{i}.png" for i in range(6)])
    first, second = ({"by": pose_program.written(tmp_path, lost)} for lost in (0, 5))
    reading, places = {"layout": "images", "poses": first}, [tmp_path / "given", tmp_path / "other"]
    pair_poses(photos, *places, poses=second, reading=reading, **kept)
    given, other = map(Capture.load, places)
    assert given.names == other.names == ("1.png", "2.png", "3.png", "4.png")
    assert not np.allclose(given.world_to_camera, other.world_to_camera)
    with pytest.raises(ValueError, match="both sources place 4 of 5 frames, 5 are needed"):
        pair_poses(photos, *places, poses=second, reading=reading, **kept | {"at_least": 5})
