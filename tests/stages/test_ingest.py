"""Captures that are too small for the experiment."""

import pytest

from fsel.stages.ingest import ingest


def test_a_capture_with_too_few_frames_is_refused(tmp_path, monkeypatch):
    few = type("Few", (), {"__len__": lambda self: 3})()
    read = type("Found", (), {"capture": few})()
    monkeypatch.setattr("fsel.stages.ingest.read_folder", lambda *a, **k: read)
    with pytest.raises(ValueError, match=r"scene: 3 usable frames, at least 50.*Hint: "):
        ingest("scene", tmp_path, long_side=64, at_least=50, reading={"layout": "colmap"})
