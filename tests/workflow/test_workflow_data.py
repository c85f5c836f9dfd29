"""The workflow's door to data: fetched, on disk, missing or damaged."""

import shutil
import subprocess
import sys
import threading
from collections import Counter
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
import yaml
from dry_runs import dry_run, planned, refusal
from layout_recordings import recording

from fsel.layouts import LAYOUTS

ROOT = Path(__file__).parents[2]
PAPER = yaml.safe_load((ROOT / "config" / "paper.yaml").read_text())


def run(folder, *arguments):
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    command += ["--configfile", "config.yaml", "--cores", "1", *arguments]
    profile = ["--workflow-profile", str(ROOT / "profiles" / "default")]
    return subprocess.run(
        [*command, *profile], cwd=folder, capture_output=True, text=True, check=False
    )


def smoke_with(folder, entry, **changes):
    """The smoke config with one more dataset, `mine`."""
    config = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())
    config |= {"datasets": config["datasets"] | {"mine": entry}} | changes
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    return f"{config['pathvars']['results']}/mine"


def test_other_scenes_go_on(tmp_path):
    """One damaged capture fails alone, its log naming the file; the others are ingested."""
    for name in ("good", "bad", "fine"):
        LAYOUTS["mipnerf360"].write(recording("mipnerf360", frames=60), tmp_path / "data" / name)
    (tmp_path / "data" / "bad" / "images_4" / "f20.jpg").write_bytes(b"")
    entry = {"label": "Mine", "root": "data", "scenes": ["bad", "fine", "good"]}
    results = smoke_with(tmp_path, entry, targets=4)
    targets = [f"{results}/{name}/images.npy" for name in entry["scenes"]]
    result = run(tmp_path, *targets)
    assert result.returncode != 0
    assert "f20.jpg: image file is empty (0 bytes)" in result.stdout + result.stderr
    made = [(tmp_path / target).exists() for target in targets]
    assert made == [False, True, True]


@pytest.fixture
def served(tmp_path):
    """Folder whose files a server on loopback gives, and its address."""
    folder = tmp_path / "served"
    folder.mkdir()
    handler = partial(SimpleHTTPRequestHandler, directory=str(folder))
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield folder, f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


def test_scenes_are_fetched_unpacked_and_read_once(tmp_path, served):
    folder, address = served
    for name in ("garden", "hall"):
        LAYOUTS["mipnerf360"].write(recording("mipnerf360", frames=60), tmp_path / "zip" / name)
    shutil.make_archive(str(folder / "both"), "zip", tmp_path / "zip")
    archive = {"url": f"{address}/both.zip"}
    table = {name: archive | {"inside": name} for name in ("garden", "hall")}
    source = {"page": address, "expects": "", "scenes": table}
    (tmp_path / "sources.yaml").write_text(yaml.safe_dump({"here": source}))
    entry = {"label": "Mine", "fetch": "here", "scenes": {"evaluation": 2}}
    results = smoke_with(tmp_path, entry, targets=4, sources="sources.yaml")
    targets = [f"{results}/{name}/images.npy" for name in table]
    result = run(tmp_path, *targets)
    assert result.returncode == 0, result.stdout + result.stderr
    assert all((tmp_path / target).is_file() for target in targets)
    assert (tmp_path / "downloads" / "here_both.zip").is_file()
    again = run(tmp_path, *targets)
    assert "Nothing to be done" in again.stdout + again.stderr


def test_the_paper_s_config_says_which_roots_are_missing(tmp_path):
    text = refusal(tmp_path, ROOT / "config" / "paper.yaml")
    unset = [name for name, entry in PAPER["datasets"].items() if "root" in entry]
    assert len(unset) == 4
    for name in unset:
        assert f"datasets.{name}.root is not set; http" in text


def test_the_paper_s_config_plans_the_whole_experiment(tmp_path):
    config = yaml.safe_load((ROOT / "config" / "paper.yaml").read_text())
    numbers = Counter()
    for name, entry in config["datasets"].items():
        scenes = entry["scenes"]
        counts = {"evaluation": len(scenes)} if isinstance(scenes, list) else scenes
        numbers.update(counts)
        if "root" in entry:
            entry["root"] = name
            found = scenes if isinstance(scenes, list) else range(sum(counts.values()))
            for scene in found:
                (tmp_path / name / str(scene)).mkdir(parents=True)
    # the paper's Table of scene counts: 21, 6, 9, 30, 30, 7
    assert numbers == {"evaluation": 103, "validation": 20, "train": 70}
    (tmp_path / "paper.yaml").write_text(yaml.safe_dump(config))
    jobs = planned(dry_run(tmp_path, tmp_path / "paper.yaml"))
    assert jobs["ingest"] == 193
    assert jobs["label"] == 90
    assert jobs["select"] == jobs["evaluate"] == 103
    assert jobs["unpack"] == 16
    assert jobs["download"] == 9
    assert "generate" not in jobs


def test_counted_scenes_are_disjoint_and_in_natural_order(tmp_path):
    for number in range(1, 13):
        (tmp_path / "data" / f"s{number}").mkdir(parents=True)
    entry = {"label": "M", "root": "data", "scenes": {"train": 2, "evaluation": 9}}
    smoke_with(tmp_path, entry)
    result = dry_run(tmp_path, tmp_path / "config.yaml")
    text = result.stdout + result.stderr
    assert "Reading the capture mine/s9\n" in text
    assert "Reading the capture mine/s12\n" not in text
    assert "mine/s10/draw0" not in text  # trained on
    assert "mine/s9/draw0" in text
