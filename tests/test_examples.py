"""The examples run as their first lines say, and so does the README's code."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from small_captures import write_ring

from fsel.selector.scorer import Network

ROOT = Path(__file__).resolve().parent.parent


def run(folder, *command):
    found = subprocess.run(
        [sys.executable, *map(str, command)], cwd=folder, capture_output=True, text=True
    )
    assert found.returncode == 0, found.stderr
    return found.stdout


def test_select_and_compare(tmp_path):
    write_ring(tmp_path / "ring")
    printed = run(tmp_path, ROOT / "examples" / "select_and_compare.py", "ring", 6).splitlines()
    assert printed[0] == "24 frames, 3 held out"
    assert [line.split()[0] for line in printed[1:4]] == ["fsel", "nearest", "uniform"]
    for line in printed[1:4]:
        assert 5 < float(line.split()[1]) < 60
    assert len(re.findall(r"frame_\d{3}\.jpg", printed[4])) == 6


def test_train_a_selector(tmp_path):
    for name in ("a", "b", "c"):
        write_ring(tmp_path / name)
    example = ROOT / "examples" / "train_a_selector.py"
    printed = run(tmp_path, example, "a", "b", "c").splitlines()
    assert printed[0] == "4 labels of 6 picks from 2 scenes"
    before, after = map(float, re.findall(r"\d+\.\d+", printed[1]))
    assert after < before
    picked, psnr = re.fullmatch(r"picked (.*): (\d+\.\d+) dB", printed[2]).groups()
    assert len(set(picked.split(", "))) == 6
    assert 5 < float(psnr) < 60
    scorer = Network.load(tmp_path / "mine.safetensors")
    assert scorer.provenance["policy"] == "less_is_more"


@pytest.mark.parametrize("page", ["README.md", "docs/cli.md"])
def test_code_in_the_docs_runs(page, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
    assert blocks
    for code in blocks:
        for folder in re.findall(r'read_capture\("([^"]*)"', code):
            write_ring(tmp_path / folder, frames=40)
        (tmp_path / "code.py").write_text(code)
        run(tmp_path, "code.py")
        assert list(tmp_path.glob("*.ply"))


def test_commands_in_the_docs_run(tmp_path):
    blocks = re.findall(r"```sh\n(.*?)```", (ROOT / "docs" / "cli.md").read_text(), re.S)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    # as few steps and pixels as a test has time for
    shorter = {"5000": "20", "--long-side 256": "--long-side 48"}
    for given, asked in shorter.items():
        lines = [line.replace(given, asked) for line in lines]
    commands = [line for line in lines if line.startswith("fsel ")]
    assert {command.split()[1] for command in commands} == {
        "demo",
        "poses",
        "select",
        "info",
        "compare",
        "reconstruct",
        "render",
        "train",
    }
    write_ring(tmp_path / "captures" / "garden", frames=60)
    # tests/cli/test_poses.py and test_train.py run those that take a minute
    words = ("walk.mp4", "mine.safetensors")
    slow = [c for c in commands if c.split()[1] in ("demo", "poses") or any(w in c for w in words)]
    for command in [command for command in commands if command not in slow]:
        run(tmp_path, "-m", *command.split(), *["--force"] * ("-o" in command.split()))
    assert (tmp_path / "garden.ply").is_file()
    assert (tmp_path / "compared" / "compare.txt").is_file()
