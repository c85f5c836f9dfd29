"""Refinement that was killed goes on where it was."""

import pytest
from small_sweep import RECONSTRUCTION

from fsel.evaluation.evaluator import Evaluator
from fsel.stages.refine import refine


def test_refinement_continues_after_a_kill(scene, tmp_path, monkeypatch):
    settings = {
        "generations": 2,
        "population": 3,
        "step": 30.0,
        "batch": 1,
        "draws": 2,
        "targets": 4,
        "budgets": [3, 5],
        "seed": 0,
    }

    def run(name: str) -> bytes:
        refine(
            [scene],
            tmp_path / f"{name}.safetensors",
            tmp_path / "log.parquet",
            scenes=["s"],
            seed=0,
            settings=settings,
            reconstruction=RECONSTRUCTION,
            inputs=[],
            config="c",
        )
        return (tmp_path / f"{name}.safetensors").read_bytes()

    whole = run("whole")
    calls = []
    scores = Evaluator.scores

    def killed(self, subset):
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return scores(self, subset)

    monkeypatch.setattr(Evaluator, "scores", killed)
    with pytest.raises(KeyboardInterrupt):
        run("killed")
    assert run("killed") == whole
