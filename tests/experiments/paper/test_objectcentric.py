"""One object of a capture: where it is, which views show it, and what leads inside its masks."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from evaluation_files import FACTS
from selection_problems import around as posed
from selection_problems import capture_of
from small_captures import ring
from small_sweep import RECONSTRUCTION, run_trials

from fsel.captures.layouts import LAYOUTS
from fsel.captures.read import read_capture
from fsel.core.capture import Capture
from fsel.experiments.paper.objectcentric import SHOWN, TRAINED, TRIALS, UNTRAINED, object_split
from fsel.experiments.paper.objectcentric import objectcentric as write_objectcentric
from fsel.metrics import METRICS
from fsel.selection.focus import from_capture
from fsel.stages.describe import describe
from fsel.synthetic import record

ASKED = {"k": 6, "draws": 2, "targets": 4, "seed": 1}


def around(frames=24, size=(32, 24)):
    """Cameras on a circle that look at the origin, and a mask of the middle of every image."""
    masks = np.zeros((frames, size[1], size[0]), bool)
    masks[:, 10:14, 14:18] = True
    return replace(posed(ring(frames), size), masks=masks)


def test_the_reference_point_by_hand():
    """Two cameras of focal length 8 at (0, 0, 0) and (4, 0, 0) look along z; a mask two pixels to
    the right of the middle in one, to its left in the other: the rays meet at (2, 0, 8)."""
    centers, rotations = np.array([[0.0, 0, 0], [4, 0, 0]]), np.tile(np.eye(3), (2, 1, 1))
    capture = capture_of(centers, rotations, None, (10, 6))
    masks = np.zeros((2, 6, 10), bool)
    masks[0, 2:4, 6:8] = True  # centroid at (7, 3), the middle of the image at (5, 3)
    masks[1, 2:4, 2:4] = True
    found = from_capture(replace(capture, masks=masks), np.arange(2))
    np.testing.assert_allclose(found.center, [2, 0, 8], atol=1e-9)


def test_masks_of_targets_are_not_looked_at():
    capture = around()
    masks = capture.masks.copy()
    masks[[3, 9]] = np.roll(masks[[3, 9]], 9, axis=2)
    rest = np.setdiff1d(np.arange(24), [3, 9])
    moved = replace(capture, masks=masks)
    expected = from_capture(capture, rest).center
    np.testing.assert_array_equal(from_capture(moved, rest).center, expected)
    assert np.abs(from_capture(moved, np.arange(24)).center - expected).max() > 1e-9


def test_an_object_that_one_frame_shows_is_refused():
    capture = around()
    masks = capture.masks & (np.arange(24) == 5)[:, None, None]
    with pytest.raises(ValueError, match=r"in 1 mask, .*24 frames were read"):
        from_capture(replace(capture, masks=masks), np.arange(24))


def test_only_frames_that_show_the_object_are_targets():
    """At the edge of the image, where no metric could be taken, does not count as shown."""
    capture = around()
    masks = capture.masks.copy()
    masks[::2] = False
    masks[::4, :, :3] = True
    masks[1, 11:] = False  # four pixels of 26 by 18: too few
    split = object_split(replace(capture, masks=masks), 0, 1, 6)
    assert set(split.targets) <= set(range(3, 24, 2))
    rest = np.concatenate([split.proxies, split.candidates])
    assert sorted([*split.targets, *rest]) == list(range(24))


def test_captures_that_show_no_object_are_refused():
    capture = around()
    with pytest.raises(ValueError, match=r"no masks.*`reading.instance`"):
        object_split(replace(capture, masks=None), 0, 0, 4)
    masks = capture.masks & (np.arange(24) < 3)[:, None, None]
    with pytest.raises(ValueError, match=r"3 frames show the object on 2% .* 4 are needed"):
        object_split(replace(capture, masks=masks), 0, 0, 4)


@pytest.fixture(scope="module", params=["scannet", "co3d"])
def stored(request, tmp_path_factory):
    """An embedded capture, written in its layout and read back, with its descriptors."""
    layout, folder = request.param, tmp_path_factory.mktemp(request.param)
    made = record(layout, 2, frames=40, width=64, height=48)
    LAYOUTS[layout].write(made, folder / "raw")
    reading = {"instance": 1} if layout == "scannet" else {}
    options = {"long_side": 32, "reading": reading, "max_error": 1}
    capture = read_capture(folder / "raw", layout, **options)
    capture.save(folder)
    described = folder / "descriptors.parquet"
    describe(folder, described, kind="lab_hog", weights=None, config="c")
    return made, folder


def test_masks_of_a_family_come_through_at_the_working_size(stored):
    made, folder = stored
    masks = Capture.load(folder).masks
    kept = made.masks[~made.lost].reshape(-1, 24, 2, 32, 2)
    assert masks.shape == (len(kept), 24, 32)
    np.testing.assert_array_equal(masks, kept.mean(axis=(2, 4)) >= 0.5)


def test_every_method_is_measured_on_every_draw(stored, tmp_path):
    _, folder = stored
    settings = {**ASKED, "long_side": RECONSTRUCTION["long_side"]}
    _, table = run_trials(TRIALS, [folder], tmp_path, settings=settings, metrics=METRICS)
    assert set(table["method"]) == set(UNTRAINED)
    assert set(table["draw"]) == {0, 1}
    assert (table.groupby(["draw", "method", "seed"]).size() == 4).all()
    assert np.isfinite(table[list(METRICS)].to_numpy()).all()
    masks = Capture.load(folder).masks
    assert masks[table["target"].unique()].any(axis=(1, 2)).all()


def test_the_table_has_a_group_of_columns_for_each_dataset(tmp_path):
    """Two scenes of two draws each; fsel leads on one dataset, on the other nobody does surely."""
    paths, scenes = [], []
    for dataset in ("scannet", "co3d"):
        for scene, psnr in (("a", 20.0), ("b", 23.0)):
            rows = []
            for draw in (0, 1):
                for name in SHOWN:
                    lead = {"co3d": 1.0, "scannet": 1.0 if scene == "a" else -0.5}[dataset]
                    more = lead if name == "fsel" else 0.0
                    values = (psnr + draw + more, 0.5 + more / 10, 0.2 - more / 10)
                    rows.append((draw, name, 0, 30, 7, *values))
            path = tmp_path / f"{dataset}{scene}.parquet"
            columns = ["draw", "method", "seed", "k", "target", *METRICS]
            pd.DataFrame(rows, columns=columns).to_parquet(path)
            paths.append(path)
            scenes.append((dataset, scene))
    outputs = tmp_path / "t.tex", tmp_path / "t.csv"
    named = {"scannet": "ScanNet v2", "co3d": "CO3D"}
    settings = {"scenes": scenes, "datasets": named, "facts": FACTS}
    write_objectcentric(paths, *outputs, metrics=METRICS, **settings)
    numbers = pd.read_csv(outputs[1])
    assert numbers["dataset"].unique().tolist() == list(named)
    assert numbers["method"].unique().tolist() == list(SHOWN)
    leading = numbers[numbers["leads"]]
    assert set(zip(leading["dataset"], leading["method"], strict=True)) == {("co3d", "fsel")}
    mean = numbers.query("metric == 'psnr'").set_index(["dataset", "method"])["mean"]
    assert mean["scannet", "fsel"] == 22.25
    assert mean["co3d", "fsel"] == 23
    assert numbers["n"].unique().tolist() == [2]
    text = outputs[0].read_text()
    assert r"\multicolumn{3}{c}{\textbf{ScanNet v2} ($n{=}2$)}" in text
    assert r"FVS & 22.00 & .500 & .200 & 22.00 & .500 & .200 \\" in text
    row = r"\textbf{fsel} & 22.25 & .525 & .175 & \textbf{23.00} & \textbf{.600} & \textbf{.100} \\"
    assert row in text
    assert list(SHOWN)[-2:] == list(TRAINED)
