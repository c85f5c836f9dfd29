"""A job's arguments by name, its log and its digest."""

import logging
import os
import re
import signal
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest
from snakemake.iocontainers import Namedlist

import fsel
from fsel.core.files import digest
from fsel.experiments.paper.learned import handsign
from fsel.workflow.functions import LISTED, function_of
from fsel.workflow.job import arguments, run


def named(**items) -> Namedlist:
    """What Snakemake hands over: one flat list, whose parts have names."""
    found = Namedlist()
    for name, value in items.items():
        start = len(found)
        found.extend(value if isinstance(value, list) else [value])
        found._set_name(name, start, end=len(found) if isinstance(value, list) else None)
    return found


def rule(input=None, output=None, params=None, wildcards=None, log=()) -> SimpleNamespace:
    """The object of a rule `taste`."""
    parts = {"input": input, "output": output, "params": params, "wildcards": wildcards}
    parts = {kind: value or named() for kind, value in parts.items()}
    return SimpleNamespace(rule="taste", threads=2, log=list(log), **parts)


CAPTURE = named(frames="r/d/s/frames.parquet", images="r/d/s/images.npy", split="r/d/s/x")
SEVERAL = named(frames=["a/f", "b/f"], points=["a/p", "b/p"], trained_frames="t/f")


@pytest.mark.parametrize(
    ("asked", "function", "found"),
    [
        (rule(named(splits=["a"])), lambda splits: None, {"splits": ["a"]}),
        # a param goes before a wildcard, and a file before its folder
        (rule(params=named(seed=3), wildcards=named(seed="3")), lambda seed: None, {"seed": 3}),
        (rule(named(frames="a/f")), lambda frames: None, {"frames": "a/f"}),
        (rule(CAPTURE), lambda folder, split: None, {"folder": "r/d/s", "split": "r/d/s/x"}),
        (rule(output=named(frames="r/d/f")), lambda folder: None, {"folder": "r/d"}),
        (
            rule(SEVERAL),
            lambda folders, trained_folder: None,
            {"folders": ["a", "b"], "trained_folder": "t"},
        ),
        (
            rule(named(splits=["a", "b"], programs=[]), named(table="t"), named(k=3, lib="c0ffee")),
            lambda splits, table, *, k, threads, config, inputs, extra=None: None,
            {"splits": ["a", "b"], "table": "t", "k": 3, "threads": 2, "config": digest({"k": 3})}
            | {"inputs": ["a", "b"]},
        ),
        (rule(wildcards=named(scene="07", dataset="d")), lambda scene: None, {"scene": "07"}),
    ],
)
def test_what_a_parameter_gets(asked, function, found):
    assert arguments(asked, function) == found


def taste(split, *, k): ...


@pytest.mark.parametrize(
    ("asked", "parts"),
    [
        (rule(named(split="a")), ["'k' has no value", "['split']"]),
        (rule(named(split="a"), params=named(k=3, kk=4)), ["['kk']", "['split', 'k']"]),
        (rule(named(split="a"), named(k="o", more="m")), ["['more']", "['split', 'k']"]),
        (rule(named(split="a", frames="f/x"), params=named(k=3)), ["['frames']"]),
        (rule(named(frames="a/f", points="b/p")), ["'points' lies in b", "['frames'] in a"]),
    ],
)
def test_what_is_missing_or_left_over_is_refused_by_name(asked, parts):
    with pytest.raises(TypeError) as refused:
        arguments(asked, taste)
    assert all(part in str(refused.value) for part in parts), refused.value


def test_a_rule_s_function_is_the_stage_of_its_name_or_a_listed_one():
    for rule in ("select", "search_oracle", "train_no_appearance", "features_labelled"):
        stage = function_of(rule)
        assert rule.startswith(stage.__name__)
        assert stage.__module__ == f"fsel.stages.{stage.__name__}"
    assert function_of("handsign") is handsign
    with pytest.raises(ValueError, match="rule taste: neither listed nor named as a stage"):
        function_of("taste")


def noted(k, config, path):
    logging.getLogger("fsel").info("a word")
    Path(path).write_text(f"{k} {config}")


def test_a_function_runs_as_a_job_whose_words_and_refusal_are_logged(tmp_path, monkeypatch):
    log, seen = tmp_path / "a.log", tmp_path / "seen"
    monkeypatch.setitem(LISTED, "taste", f"{__name__}:noted")
    params = {"k": 3, "path": str(seen)}
    run(rule(params=named(**params), log=[str(log)]))
    assert seen.read_text() == f"3 {digest(params)}"
    assert log.read_text().endswith("INFO fsel: a word\n")
    with pytest.raises(TypeError, match="'k' has no value"):
        run(rule(params=named(), log=[str(log)]))
    assert "TypeError: rule taste" in log.read_text()


def terminated():
    import_module("fsel.captures.layouts.colmap")  # the log of pycolmap would print a stack
    os.kill(os.getpid(), signal.SIGTERM)


def test_a_job_that_is_terminated_ends_in_order(tmp_path, monkeypatch, capfd):
    log = tmp_path / "a.log"
    monkeypatch.setitem(LISTED, "taste", f"{__name__}:terminated")
    with pytest.raises(SystemExit) as ended:
        run(rule(log=[str(log)]))
    assert ended.value.code == 143
    assert "SystemExit: 143" in log.read_text()
    assert capfd.readouterr().err == ""


def test_everything_imports_pycolmap_without_its_handlers():
    library = Path(fsel.__file__).parent
    found = [
        p
        for p in library.rglob("*.py")
        if p.parent.name != "recipes"  # programs of their own
        and re.search(r"^\s*(import|from) pycolmap", p.read_text(), re.M)
    ]
    assert len(found) == 1, found
