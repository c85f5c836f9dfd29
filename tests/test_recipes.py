"""The recipes of docs/extend.md, followed as written in a copy of the repository."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from small_captures import SIZE, write_ring

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "extend.md"
STEP = re.compile(
    r"(?:^`(?P<file>[^`\n]+)`:\n\n"
    r"|^In `(?P<edited>[^`\n]+)`, below the line with `(?P<anchor>[^`\n]+)`:\n\n)?"
    r"^```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.M | re.S,
)


def recipes():
    """Title -> its steps, in order."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(), flags=re.M)[1:]
    return dict(zip(parts[::2], (list(STEP.finditer(text)) for text in parts[1::2]), strict=True))


def follow(root, step, environment):
    """Write a file, add lines to one, or run commands."""
    if step["file"]:
        path = root / step["file"]
        assert not path.exists(), f"{path} exists already"
        path.write_text(step["text"])
    elif step["edited"]:
        path = root / step["edited"]
        lines = path.read_text().splitlines(keepends=True)
        (at,) = [i for i, line in enumerate(lines) if step["anchor"] in line]
        path.write_text("".join([*lines[: at + 1], step["text"], *lines[at + 1 :]]))
    else:
        assert step["language"] == "sh", f"a step that says nothing of its place: {step[0]}"
        done = subprocess.run(
            ["bash", "-ec", step["text"]], cwd=root, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{step['text']}\n{done.stdout}\n{done.stderr}"


def write_desk(folder, poses):
    """The ring in the layout that a recipe adds."""
    lines = []
    for i, pose in enumerate(poses):
        numbers = [60, 61, SIZE[0] / 2, SIZE[1] / 2, *pose.ravel()]
        lines.append(",".join([f"images/frame_{i:03d}.jpg", *map(repr, map(float, numbers))]))
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """A copy of the repository in which every recipe was followed."""
    root = tmp_path_factory.mktemp("a copy")
    for name in ("src", "workflow", "config", "docs"):
        ignored = shutil.ignore_patterns("*.egg-info", "__pycache__")
        shutil.copytree(ROOT / name, root / name, ignore=ignored)
    for folder in {path.parent for path in (ROOT / "src").rglob("*.py")}:
        compiled = folder / "__pycache__"  # what either compiles, the other finds
        compiled.mkdir(exist_ok=True)
        (root / compiled.relative_to(ROOT)).symlink_to(compiled)
    shutil.copy(ROOT / "Snakefile", root)
    write_ring(root / "captures" / "garden", frames=40)
    poses, _ = write_ring(root / "captures" / "desk", frames=40)
    shutil.rmtree(root / "captures" / "desk" / "sparse")
    write_desk(root / "captures" / "desk", poses)
    (root / "bin").mkdir()
    (root / "bin" / "fsel").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m fsel "$@"\n')
    (root / "bin" / "fsel").chmod(0o755)
    search = [str(root / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]]
    environment = os.environ | {
        "PATH": os.pathsep.join(search),
        "PYTHONPATH": str(root / "src"),
        "PYTHONWARNINGS": "ignore",
    }
    for steps in recipes().values():
        for step in steps:
            follow(root, step, environment)
    return root


def test_there_is_a_recipe_for_each_kind():
    kinds = ["baseline", "layout", "reconstructor", "metric", "table", "dataset"]
    assert list(recipes()) == [f"Add a {kind}" for kind in kinds]
    assert all(recipes().values())


def test_what_was_added_is_in_the_sweep(extended):
    sweep = pd.read_csv(extended / "results" / "mine" / "tables" / "ksweep.csv")
    assert set(sweep["dataset"]) == {"mine"}
    assert set(sweep["metric"]) == {"psnr", "mae"}
    rows = sweep[sweep["method"] == "middle"].set_index("metric")
    assert rows.loc["mae", "mean"] > 0
    assert 5 < rows.loc["psnr", "mean"] < 40
    text = (extended / "results/mine/tables/ksweep.tex").read_text()
    assert "Middle" in text
    assert r"PSNR$\uparrow$~/~MAE$\downarrow$" in text


def test_the_command_knows_the_baseline(extended):
    assert "middle" in (extended / "compared" / "compare.txt").read_text()


def test_the_table_measures_the_new_dataset(extended):
    sizes = pd.read_csv(extended / "results" / "mine" / "tables" / "capture_sizes.csv")
    assert sizes["scene"].tolist() == ["mine/desk"]
    assert sizes["frames"].tolist() == [40]
