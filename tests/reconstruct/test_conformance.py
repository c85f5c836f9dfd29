"""The check of workers: a good one passes, and each fault is found where it is."""

import json
import re
import sys

import pytest
from jsonschema import Draft202012Validator

from fsel.cli import main, worker
from fsel.reconstruct.external.conformance import CHECKS, SCHEMA, Checks
from fsel.reconstruct.external.settings import ExternalSettings
from fsel.reconstruct.external.worker import Worker

GOOD = """
import os, sys, time
import numpy as np
from fsel_worker import serve

kept, last = [], None

def fit(subset):
    global last
    last = subset.images.mean(axis=0, dtype=np.float32) / 255
    FIT
    return last

def many(subsets):
    return [fit(subset) for subset in subsets]

def render(model, views):
    images = np.stack([model] * len(views))
    RENDER
    return images

serve(FITS, render, name="mean", version="1", needs=NEEDS, together=TOGETHER)
STOP
"""


def program(together=1, needs=(), fit="pass", render="pass", stop=""):
    text = GOOD.replace("FITS", "fit" if together == 1 else "many").replace("STOP", stop)
    text = text.replace("NEEDS", repr(list(needs))).replace("TOGETHER", str(together))
    return [sys.executable, "-c", text.replace("FIT", fit).replace("RENDER", render)]


def failed(serve):
    found = Checks(ExternalSettings(serve=serve, timeout=20)).run()
    return {checked.title: checked.wrong for checked in found if checked.wrong}


@pytest.mark.parametrize("together", [1, 4])
def test_a_good_worker_passes(together):
    checked = list(Checks(ExternalSettings(serve=program(together, ["points"]))).run())
    assert [one.title for one in checked] == list(CHECKS)
    assert [one.wrong for one in checked] == [""] * len(CHECKS)
    assert checked[0].note == f"mean 1 on cpu; needs points; {together} at once; float32"


@pytest.mark.parametrize(
    ("wrong", "title", "said"),
    [
        ({"render": "images *= 2"}, "fits and renders", "allowed: 0 to 1"),
        ({"render": "images[0] = np.inf"}, "fits and renders", "not finite"),
        ({"render": "images /= len(views)"}, "fits and renders", "a view alone and among others"),
        ({"render": "images = np.stack([last] * len(views))"}, "keeps models apart", "differ by"),
        (
            {"together": 3, "fit": "last += len(kept); kept.append(1)"},
            "takes batches",
            "a subset alone and in a batch differ",
        ),
        ({"fit": "kept.append(np.ones(500_000))"}, "forgets what was closed", "grows by 4.0 MB"),
        (
            {"render": "images = images[:, :48]"},
            "takes another capture",
            r"shape \(2, 48, 40, 3\), expected \(2, 56, 40, 3\)",
        ),
        ({"stop": "sys.exit(4)"}, "ends with its input", "exit code 4; allowed: 0"),
    ],
)
def test_each_fault_is_found(wrong, title, said):
    found = failed(program(**wrong))
    assert title in found
    assert re.search(said, found[title])


RAW = """
import json, sys
for line in sys.stdin:
    request = json.loads(line)
    answer = {"ok": True, "protocol": 1, "name": "raw", "version": "", "device": "cpu",
              "needs": [], "together": 1, "pixels": "float32"}
    if request["do"] == "fit":
        answer = ANSWER
    if request["do"] != "close":
        print(json.dumps(answer), flush=True)
"""


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("{'ok': True}", "'models' is a required property"),
        ("{'ok': True, 'models': [{'seconds': -1}]}", "-1 is less than the minimum of 0"),
        ("{'ok': True, 'models': [{'model': 0, 'device': 5}]}", "5 is not of type 'string'"),
        ("{'ok': 'yes'}", "what is no answer"),
    ],
)
def test_answers_are_compared_with_the_protocol(answer, said):
    assert said in failed([sys.executable, "-c", RAW.replace("ANSWER", answer)])["fits and renders"]


def test_requests_are_as_the_schema_says(monkeypatch):
    sent = []
    tell = Worker.tell

    def kept(self, request):
        sent.append(request)
        tell(self, request)

    monkeypatch.setattr(Worker, "tell", kept)
    list(Checks(ExternalSettings(serve=program(2))).run())
    schema = json.loads(SCHEMA.read_text())
    Draft202012Validator.check_schema(schema)
    for request in sent:
        Draft202012Validator(schema).validate(json.loads(json.dumps(request)))
    assert {request["do"] for request in sent} == {"hello", "bind", "fit", "render", "close"}


def test_the_command_says_what_is_wrong(capsys):
    arguments = ["reconstruct", "--check-worker", "--timeout", "20", "--"]
    assert main([*arguments, *program()]) == 0
    assert capsys.readouterr().out.startswith("ok        states itself\n")
    assert main([*arguments, *program(stop="sys.exit(4)")]) == 1
    told = capsys.readouterr()
    assert "wrong     ends with its input\n          it ended with exit code 4" in told.out
    assert told.err == "fsel: 1 check failed: ends with its input\n"
    assert main([*arguments, "no_such_program"]) == 1
    assert "no program 'no_such_program'" in capsys.readouterr().err


def test_the_command_measures_costs(tmp_path, capsys):
    arguments = ["reconstruct", "--cost", "-k", "4", "--views", "2", "--json"]
    *python, text = program(fit="time.sleep(0.05)")
    assert main([*arguments, "--", *python, "import time; time.sleep(0.2)" + text]) == 0
    cost = json.loads(capsys.readouterr().out)["cost"]["external"]
    assert list(cost) == ["load", "fit", "render", "peak_bytes", "device"]
    assert 0.05 <= cost["fit"] < 30
    assert 0.2 <= cost["load"] < 60
    recipe = tmp_path / "two.yaml"
    recipe.write_text("reconstruction: [{name: splats}, {name: splats, as: again, long_side: 32}]")
    assert main([*arguments, "--recipe", str(recipe)]) == 0
    assert list(json.loads(capsys.readouterr().out)["cost"]) == ["splats", "again"]


def test_the_command_says_which_package_it_lacks(monkeypatch, capsys):
    monkeypatch.setattr(worker, "find_spec", lambda package: None)
    assert main(["reconstruct", "--check-worker", "--", "true"]) == 1
    said = "fsel: --check-worker needs jsonschema. Hint: pip install 'fsel[workflow]'\n"
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--cost"], "name a program after --, as in `-- python mine.py`, or give --recipe"),
        (["--check-worker", "--recipe", "a.yaml"], "--check-worker takes a program, not --recipe"),
        (["--cost", "--recipe", "no.yaml"], "no.yaml: No such file or directory"),
        (
            ["--cost", "--recipe", "a.yaml", "--gpu"],
            "--venv and --gpu go with a program; a recipe states its own",
        ),
    ],
)
def test_the_command_refuses(arguments, said, capsys):
    assert main(["reconstruct", *arguments]) == 1
    assert capsys.readouterr().err == f"fsel: {said}\n"
