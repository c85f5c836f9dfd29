"""One baseline, layout, reconstructor, metric and table more: a file and a line each, and run."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parents[2]
ADDITIONS = Path(__file__).parent / "additions"
# file -> the line that another one is added after, and that line
LINES = {
    "src/fsel/baselines/__init__.py": (
        '        "nearest": "fsel.baselines.nearest:METHOD",\n',
        '        "last": "fsel.baselines.last:METHOD",\n',
    ),
    "src/fsel/layouts/__init__.py": (
        '        "colmap": "fsel.layouts.colmap:LAYOUT",\n',
        '        "arrays": "fsel.layouts.arrays:LAYOUT",\n',
    ),
    "src/fsel/reconstruct/__init__.py": (
        '        "splats": "fsel.reconstruct.splats:Splats",\n',
        '        "mean_color": "fsel.reconstruct.mean_color:MeanColor",\n',
    ),
    "src/fsel/metrics/__init__.py": (
        '        "gmsd": "fsel.metrics.builtin:GMSD",\n',
        '        "mae": "fsel.metrics.mae:METRIC",\n',
    ),
    "Snakefile": (
        'include: "workflow/rules/paper.smk"\n',
        'include: "workflow/rules/counts.smk"\n',
    ),
}


def in_copy(folder: Path, *command: str) -> str:
    """What a command prints that is run in a copy of the repository."""
    done = subprocess.run(
        [sys.executable, "-m", *command],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(folder / "src"), "PYTHONWARNINGS": "ignore"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """The tables of a copy of the repository with the additions."""
    folder = tmp_path_factory.mktemp("added") / "fsel"
    folder.mkdir()
    for part in ("src", "workflow", "config"):  # compiled code with it, which takes minutes to make
        shutil.copytree(ROOT / part, folder / part)
    shutil.copy2(ROOT / "Snakefile", folder)
    shutil.copytree(ADDITIONS, folder, dirs_exist_ok=True)
    for name, (before, line) in LINES.items():
        text = (folder / name).read_text()
        assert text.count(before) == 1, name
        (folder / name).write_text(text.replace(before, before + line))
    in_copy(folder, "fsel.stages.schema")
    asked = [f"results/tables/{name}.csv" for name in ("ksweep", "counts")]
    options = ["--cores", "1", "--workflow-profile", "none", "--configfile", "config.yaml"]
    in_copy(folder, "snakemake", *options, "--", *asked)
    return folder / "results" / "tables"


def test_the_sweep_has_the_new_baseline_and_metric_of_the_new_layout(tables):
    sweep = pd.read_csv(tables / "ksweep.csv")
    assert set(sweep["dataset"]) == {"arrays"}
    assert set(sweep["metric"]) == {"psnr", "mae"}
    assert {"last", "nearest", "ours", "fsel", "all"} <= set(sweep["method"])
    found = sweep.set_index(["method", "metric"])["mean"]
    # one colour a frame is far from the truth, yet no noise
    assert (found.xs("mae", level="metric").between(0.02, 0.5)).all()
    text = (tables / "ksweep.tex").read_text()
    assert "Last frames" in text
    assert r"PSNR$\uparrow$~/~MAE$\downarrow$" in text
    assert "mean\\_color" in text


def test_the_new_table_counts_the_capture(tables):
    assert pd.read_csv(tables / "counts.csv").values.tolist() == [["arrays", "evaluation00", 30]]
    assert "Arrays & evaluation00 & 30" in (tables / "counts.tex").read_text()
