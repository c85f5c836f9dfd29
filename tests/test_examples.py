"""The examples run as their first lines say, and so does the README's code."""

import re
import runpy
import sys
from ast import literal_eval
from dataclasses import replace
from pathlib import Path

import nbformat
import pytest
from PIL import Image
from small_captures import write_ring

from fsel.cli import main
from fsel.reconstruct.gaussians.settings import QUALITIES
from fsel.selectors.scorer import Network

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run a program in the folder of the test, as `python PROGRAM ARGUMENTS` would."""
    monkeypatch.chdir(tmp_path)

    def run(program, *arguments):
        monkeypatch.setattr(sys, "argv", [str(program), *map(str, arguments)])
        runpy.run_path(str(program), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_select_and_compare(tmp_path, run, quick_trials):
    write_ring(tmp_path / "ring")
    printed = run(ROOT / "examples" / "select_and_compare.py", "ring", 6).splitlines()
    assert printed[0] == "24 frames, 3 held out"
    assert [line.split()[0] for line in printed[1:4]] == ["fsel", "nearest", "uniform"]
    for line in printed[1:4]:
        assert 5 < float(line.split()[1]) < 60
    assert len(re.findall(r"frame_\d{3}\.jpg", printed[4])) == 6


def test_train_a_selector(tmp_path, run):
    for name in ("a", "b", "c"):
        write_ring(tmp_path / name)
    example = ROOT / "examples" / "train_a_selector.py"
    printed = run(example, "a", "b", "c").splitlines()
    assert printed[0] == "4 labels of 6 picks from 2 scenes"
    before, after = map(float, re.findall(r"\d+\.\d+", printed[1]))
    assert after < before
    picked, psnr = re.fullmatch(r"picked (.*): (\d+\.\d+) dB", printed[2]).groups()
    assert len(set(picked.split(", "))) == 6
    assert 5 < float(psnr) < 60
    scorer = Network.load(tmp_path / "mine.safetensors")
    assert scorer.provenance["policy"] == "less_is_more"


def test_side_by_side(tmp_path, run):
    write_ring(tmp_path / "ring")
    example = ROOT / "examples" / "side_by_side.py"
    fewer = ["--targets", "2:12:4", "-k", "6", "--long-side", "48"]
    sooner = ["--steps", "30", "--gaussians", "500", "--pictures", "3", "--clip", "a.webp"]
    printed = run(example, "--capture", "ring", *fewer, *sooner).splitlines()
    assert printed[0] == "24 frames, 3 held out, 6 to select"
    assert re.fullmatch(r"uniform sampling: \d+\.\d\d dB, frames \[.*\]", printed[1])
    assert re.fullmatch(r"fsel: \d+\.\d\d dB, frames \[.*\]", printed[2])
    with Image.open(tmp_path / "a.webp") as clip:
        assert (clip.n_frames, clip.size) == (4, (96, 36 + 24))


def test_the_notebook_shows_what_it_computes_and_that_the_picks_are_ahead(tmp_path, run):
    notebook = nbformat.read(ROOT / "examples" / "which_frames.ipynb", as_version=4)
    nbformat.validate(notebook)
    lines, shown = [], []
    for cell in [cell for cell in notebook.cells if cell["cell_type"] == "code"]:
        *body, last = cell["source"].splitlines()
        shown += [literal_eval(output["data"]["text/plain"]) for output in cell["outputs"]]
        lines += [*body, f"print(({last}))" if cell["outputs"] else last]
    (tmp_path / "cells.py").write_text("\n".join(lines))
    assert [literal_eval(line) for line in run("cells.py").splitlines()] == shown
    scores = {row[:2]: row[2] for row in shown[2]}
    assert all(scores["fsel", k] > scores["uniform", k] for k in (6, 10, 15))


@pytest.mark.parametrize("page", ["README.md", "docs/reference.md"])
def test_code_in_the_docs_runs(page, tmp_path, run, quick_trials):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
    assert blocks
    for code in blocks:
        for folder in re.findall(r'read_capture\("([^"]*)"', code):
            write_ring(tmp_path / folder, frames=40)
        (tmp_path / "code.py").write_text(code)
        run("code.py")
        assert list(tmp_path.glob("*.ply"))


def test_commands_in_the_docs_run(tmp_path, quick_trials, monkeypatch):
    blocks = re.findall(r"```sh\n(.*?)```", (ROOT / "docs" / "cli.md").read_text(), re.S)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    # as few steps, pixels and frames as a test has time for
    shorter = {
        "-k 10,20,30": "-k 10,12 --reconstructor splats --long-side 48",
        "--video garden.mp4": "--video garden.mp4 --seconds 0.2 --long-side 96",
    }
    quick = replace(QUALITIES["draft"], long_side=48, gaussians=200, steps=3)
    monkeypatch.setitem(QUALITIES, "draft", quick)
    for given, small in shorter.items():
        lines = [line.replace(given, small) for line in lines]
    commands = [line for line in lines if line.startswith("fsel ")]
    outputs = re.findall(r" (?:-o|--video) (\S+)", "\n".join(commands))
    assert len(set(outputs)) == len(outputs) > 9  # they can be typed in turn
    every = "demo poses select info compare reconstruct render view"
    assert {command.split()[1] for command in commands} == set(every.split())
    write_ring(tmp_path / "captures" / "garden", frames=40)
    # tests/cli/test_poses.py runs those that take a minute
    slow = [c for c in commands if c.split()[1] in ("demo", "poses") or "walk.mp4" in c]
    monkeypatch.chdir(tmp_path)
    for command in [command for command in commands if command not in slow]:
        words = command.split()[1:]
        assert main([*words, *["--force"] * ("-o" in words)]) == 0, command
    assert (tmp_path / "garden.ply").is_file()
    assert (tmp_path / "compared" / "compare.txt").is_file()
