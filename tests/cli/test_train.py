"""`fsel train`: from captures to weights that select, resumed where it was cut off."""

import json
from dataclasses import replace

import numpy as np
import pytest
from small_captures import select, write_ring

from fsel.cli import main
from fsel.selectors import pretrained
from fsel.training import offline
from fsel.training.search import GeneticSettings

SMALL = GeneticSettings(population=6, farthest=2, uniform=2, generations=1)


@pytest.fixture
def captures(tmp_path, monkeypatch):
    """Two captures, and searches of 10 subsets of 4 frames."""
    paths = [tmp_path / name for name in ("a", "b")]
    for path in paths:
        write_ring(path)
    fields = {"k": 4, "search": SMALL, "stored": 4, "kept": 2}
    made = offline.Labelling
    monkeypatch.setattr(offline, "Labelling", lambda **given: made(**given, **fields))
    return paths


def train(*words):
    options = ("--coverages", "25,40", "--long-side", "48", "--epochs", "3")
    return main(["train", *map(str, words), *options])


def test_trained_weights_select_and_say_where_they_come_from(captures, tmp_path, capsys):
    out = tmp_path / "mine.safetensors"
    assert train(*captures, "-o", out) == 0
    said = capsys.readouterr().out
    assert "4 problems of up to 10 reconstructions: about" in said
    assert "4 of 4" in said
    method = pretrained.own(out)
    assert method.name == "less_is_more"
    assert method.scorer.provenance["made by"].startswith(
        "fsel train: behaviour cloning of 8 searched subsets of 2 captures, 3 epochs"
    )
    assert not list(tmp_path.glob(".mine*"))
    assert select(captures[0], "-k", 5, "--weights", out, "-o", tmp_path / "picked") == 0
    assert train(*captures, "-o", out) == 1
    assert "exists already" in capsys.readouterr().err
    before = method.scorer.weights
    assert train(*captures, "-o", out, "--force", "--json") == 0
    again = pretrained.own(out).scorer.weights
    assert all(np.array_equal(again[name], before[name]) for name in before)
    assert len(json.loads(capsys.readouterr().out)["epochs"]) == 4


def test_a_run_that_was_cut_off_goes_on(captures, tmp_path, monkeypatch, capsys):
    out, done = tmp_path / "mine.safetensors", []
    measure = offline.Evaluator.__call__

    def counted(self, subset):
        if len(done) == limit:
            raise ValueError("cut off")
        done.append(tuple(subset))
        return measure(self, subset)

    monkeypatch.setattr(offline, "seconds_needed", lambda task, labelling: 0.0)
    monkeypatch.setattr(offline.Evaluator, "__call__", counted)
    limit = 15
    assert train(*captures, "-o", out) == 1
    assert not out.exists()
    limit = None
    assert train(*captures, "-o", out) == 0
    assert "after 15 reconstructions of an earlier run" in capsys.readouterr().out
    met = len(done)
    done.clear()
    assert train(*captures, "-o", tmp_path / "other.safetensors") == 0
    assert len(done) == met
    first, second = (pretrained.own(tmp_path / f"{n}.safetensors") for n in ("mine", "other"))
    for name, array in first.scorer.weights.items():
        np.testing.assert_array_equal(array, second.scorer.weights[name])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "mine.json"], "written as .safetensors"),
        (
            ["-o", "x.safetensors", "--method", "fsel"],
            "allowed: less_is_more_no_appearance, less_is_more",
        ),
        (["-o", "x.safetensors", "--reconstructor", "nerf"], "allowed: splats"),
        (["-o", "a/x.safetensors"], "may not be, hold or lie in what is read"),
    ],
)
def test_what_cannot_be_trained_is_refused_at_once(
    words, said, captures, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "a", "b", *words]) == 1
    assert said in capsys.readouterr().err


def test_a_capture_of_too_few_frames_is_refused(captures, tmp_path, capsys, monkeypatch):
    few = replace(offline.Labelling(), k=20)
    monkeypatch.setattr(offline, "Labelling", lambda **given: few)
    assert train(captures[0], "-o", tmp_path / "x.safetensors") == 1
    assert "24 frames, at least 50 are needed" in capsys.readouterr().err
