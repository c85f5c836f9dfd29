"""Parts that another installed package registers by its entry points."""

import os

import pytest
from own_python import printed
from small_captures import write_ring

from fsel.core.registry import Registry

PARTS = '''
import numpy as np
from types import SimpleNamespace

from fsel.captures.colmap.camera import Camera
from fsel.core.problem import Method
from fsel.captures.layouts.contract import Layout
from fsel.captures.layouts.colmap import read
from fsel.metrics import Metric

FIRST = Method(
    "first", "First", "observed", nested=True, seeds=1,
    select=lambda problem, k, rng: problem.observed[:k],
)
MARKED = Layout("marked", lambda folder: (folder / "marked").is_file(), read)
MAE = Metric(
    "mae", "MAE", higher_is_better=False,
    score=lambda rendered, truth, masks: np.abs(rendered - truth / 255).mean(axis=(1, 2, 3)),
)


class Grey:
    """Every view is grey."""

    check = staticmethod(lambda: None)

    def __init__(self, capture):
        self.capture = capture

    def fit(self, frames):
        shape = (*self.capture.size[::-1], 3)
        cost = dict(primitives=0, bytes=0, seconds=0.0, peak_bytes=0, device="cpu")
        return SimpleNamespace(
            render=lambda views: np.full((len(views), *shape), 0.5, np.float32), **cost
        )
'''
POINTS = """
[fsel.selectors.baselines]
first = own_parts:FIRST
[fsel.captures.layouts]
marked = own_parts:MARKED
[fsel.metrics]
mae = own_parts:MAE
[fsel.reconstructors]
grey = own_parts:Grey
"""
UNIFORM = "fsel.selectors.baselines.simple:UNIFORM"
CALLS = """
import fsel
from fsel.captures.read import recognise
from fsel.cli import main

assert recognise("ring") == ["marked", "colmap"], recognise("ring")
capture = fsel.read_capture("ring", long_side=64)
chosen = fsel.select(capture, 5, targets="every:6", method="first")
assert chosen.indices.tolist() == [1, 2, 3, 4, 5]
assert list(fsel.METHODS)[-1] == "first" and "first" in repr(fsel.METHODS)
model = fsel.fit(capture, chosen.indices, "grey")
scores = fsel.evaluate(capture, model, [0, 6], ["psnr", "mae"])
truth = capture.images[[0, 6]] / 255
assert abs(scores["mae"] - abs(truth - 0.5).mean(axis=(1, 2, 3))).max() < 1e-6
line = "compare ring -k 4 --methods first,fsel --metrics psnr,mae --reconstructor grey -o out"
assert main(line.split()) == 0
"""


def install(folder, points=POINTS):
    """Write a package as an installer leaves it."""
    (folder / "own_parts.py").write_text(PARTS)
    info = folder / "own_parts-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-parts\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(points)


def test_calls_and_commands_know_the_parts_of_another_package(tmp_path):
    write_ring(tmp_path / "ring")
    (tmp_path / "ring" / "marked").touch()
    install(tmp_path)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    assert "24 frames, marked" in printed(CALLS, folder=tmp_path, PYTHONPATH=path)
    assert "MAE" in (tmp_path / "out" / "compare.txt").read_text()


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ("uniform = own_parts:FIRST", r"own-parts: method 'uniform' .* name of another"),
        ("last = own_parts:FIRST", r"method 'last' \(own_parts:FIRST\) calls itself 'first'"),
        ("last = own_parts:LAST", r"method 'last' \(own_parts:LAST\): .*no attribute 'LAST'"),
        ("last = absent:LAST", "method 'last' .* needs absent, which is not installed"),
    ],
)
def test_parts_that_cannot_be_registered_are_named(points, said, tmp_path, monkeypatch):
    install(tmp_path, f"[own.methods]\n{points}\n")
    monkeypatch.syspath_prepend(tmp_path)
    registry = Registry("method", {"uniform": UNIFORM}, group="own.methods")
    with pytest.raises((ValueError, ImportError), match=said):
        registry.checked("last")


def test_own_entries_may_call_themselves_otherwise():
    registry = Registry("part", {"first": UNIFORM}, group="no.group")
    assert registry["first"].name == "uniform"
