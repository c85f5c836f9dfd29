"""A small scene through the stages: described, labelled, selected and evaluated."""

import numpy as np
import pytest
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.capture import Capture
from fsel.metrics import METRICS
from fsel.stages.describe import describe
from fsel.stages.evaluate import evaluate
from fsel.stages.label import label
from fsel.stages.order import order
from fsel.stages.select import select
from fsel.stages.split import split
from fsel.synthesis import record


@pytest.fixture(scope="session")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors."""
    folder = tmp_path_factory.mktemp("scene")
    recording = record("dl3dv", 3, frames=40, width=32, height=24)
    camera = recording.camera
    focal = camera.params[0]
    Capture(
        names=recording.names,
        world_to_camera=recording.world_to_camera,
        intrinsics=np.tile([focal, focal, 16.0, 12.0], (40, 1)),
        images=recording.images,
        sequences=recording.sequences,
    ).save(folder)
    describe(folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    return folder


@pytest.fixture(scope="session")
def labelled(scene, tmp_path_factory):
    """One coverage level of one scene, searched and ordered."""
    folder = tmp_path_factory.mktemp("labelled")
    splits, labels = folder / "splits.parquet", [folder / "p25.parquet"]
    shared = {"coverages": [25], "config": "c"}
    settings = {"seed": 5, "search": SEARCH, "reconstruction": RECONSTRUCTION, "inputs": []}
    settings["fitness"] = METRICS
    label(scene, labels, splits, **settings, **shared)
    trajectories = folder / "trajectories.parquet"
    order([scene], [splits], labels, trajectories, scenes={"s": "train"}, kept=2, **shared)
    return folder


@pytest.fixture(scope="session")
def swept(scene, tmp_path_factory):
    """Two draws of one scene, selected and evaluated by every method without weights."""
    folder = tmp_path_factory.mktemp("swept")
    draws = [folder / f"draw{d}" for d in range(2)]
    splits, picks, outputs = (
        [draw / f"{name}.parquet" for draw in draws]
        for name in ("split", "selections", "evaluation")
    )
    split(scene, splits, targets=4, seed=1, config="c")
    select(scene, splits, [], picks, budgets=[3, 5], seeds=[2, 2], config="c")
    settings = {"reconstruction": RECONSTRUCTION, "metrics": METRICS}
    evaluate(scene, splits, picks, outputs, **settings, config="c")
    return draws
