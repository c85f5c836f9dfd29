"""The examples in the docstrings of public functions run as they stand."""

import doctest

import pytest
from small_captures import write_ring

import fsel
from fsel.core import limits

SHOWN = [
    *(fsel.read_capture, fsel.select, fsel.Selection.export, fsel.fit, fsel.evaluate),
    fsel.how_many,
    *(fsel.bad_frames, fsel.Auto, fsel.set_threads, fsel.Capture.resized, fsel.Capture.subset),
]


@pytest.fixture(scope="module")
def garden(tmp_path_factory):
    """A folder with the capture of the examples."""
    folder = tmp_path_factory.mktemp("garden")
    write_ring(folder / "captures" / "garden", frames=80)
    return folder


@pytest.mark.parametrize("shown", SHOWN, ids=lambda shown: shown.__qualname__)
def test_an_example_runs(shown, garden, quick_trials, monkeypatch):
    monkeypatch.chdir(garden)
    monkeypatch.setenv(limits.THREADS, "")
    (example,) = doctest.DocTestFinder(recurse=False).find(shown, globs={"fsel": fsel})
    found = doctest.DocTestRunner().run(example)
    assert found.attempted > 0
    assert found.failed == 0
