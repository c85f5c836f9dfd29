"""Refinement that was killed goes on where it was."""

import pytest
from small_sweep import RECONSTRUCTION

from fsel.stages.refine import refine


def test_refinement_continues_after_a_kill(scene, tmp_path, kill):
    settings = {"generations": 2, "population": 3, "step": 30.0, "batch": 1}
    settings |= {"draws": 2, "targets": 4, "budgets": [3, 5], "seed": 0}
    asked = {"scenes": ["s"], "seed": 0, "settings": settings, "inputs": [], "config": "c"}

    def run(name: str) -> bytes:
        path = tmp_path / f"{name}.safetensors"
        refine([scene], path, tmp_path / "log", reconstruction=RECONSTRUCTION, **asked)
        return path.read_bytes()

    whole = run("whole")
    kill(4)
    with pytest.raises(KeyboardInterrupt):
        run("killed")
    assert run("killed") == whole
