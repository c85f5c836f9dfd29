"""The workflow's door to data: fetched, on disk, missing or damaged."""

import re
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
PAPER_RULES = (ROOT / "workflow" / "rules" / "needs.smk").read_text().split("PAPER = {")[1]
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
    assert len(unset) == 6
    for name in unset:
        assert f"datasets.{name}.root is not set; http" in text


def paper_config(folder, absent=()):
    """The paper's config over folders of the right shape, those of some datasets left out."""
    config = yaml.safe_load((ROOT / "config" / "paper.yaml").read_text())
    for name, entry in config["datasets"].items():
        if "root" not in entry or name in absent:
            continue
        entry["root"], scenes = name, entry["scenes"]
        found = scenes if isinstance(scenes, list) else range(sum(scenes.values()))
        for scene in found:
            (folder / name / str(scene)).mkdir(parents=True)
        if name == "scannet":
            entry["reading"] = {"instance": {str(scene): 1 for scene in found}}
        if name == config["pose_sources"]["dataset"]:
            for scene in range(scenes["evaluation"]):
                (folder / name / str(scene) / config["pose_sources"]["model"]).mkdir(parents=True)
    (folder / "paper.yaml").write_text(yaml.safe_dump(config))
    return folder / "paper.yaml"


def test_the_paper_s_config_plans_the_sweep(tmp_path):
    numbers = Counter()
    for entry in PAPER["datasets"].values():
        scenes = entry["scenes"]
        numbers.update({"evaluation": len(scenes)} if isinstance(scenes, list) else scenes)
    # the paper's tables of scene counts: 21, 6, 9, 30, 30, 7; 30 of ScanNet++ for features; objects
    assert numbers == {"evaluation": 103, "validation": 50, "train": 70, "object": 20}
    jobs = planned(dry_run(tmp_path, paper_config(tmp_path)))
    assert jobs["ingest"] == 193
    assert jobs["label"] == 90
    assert jobs["select"] == jobs["evaluate"] == 103
    assert jobs["search_oracle"] == 21
    assert jobs["unpack"] == 16
    assert jobs["download"] == 9
    assert not {"generate", "refine"} & set(jobs)


def test_the_paper_s_config_plans_every_table(tmp_path):
    result = dry_run(tmp_path, paper_config(tmp_path), "paper")
    jobs = planned(result)
    text = result.stdout + result.stderr
    assert "can be made" not in text
    tables = set(re.findall(r"<tables>/(\w+)\.tex", PAPER_RULES))
    assert tables <= set(jobs)
    assert len(tables) >= 12
    assert jobs["select_crosscapture"] == 6
    assert jobs["select_objects"] == 20
    assert jobs["select_paired"] == jobs["evaluate_paired"] == 21
    assert jobs["evaluate_trials"] == 30 + 21
    assert jobs["qualitative"] == 6
    assert "refine" not in jobs


def test_what_cannot_be_made_of_the_paper_is_listed_and_blocks_nothing_else(tmp_path):
    config = paper_config(tmp_path, absent=["tanks_and_temples", "scannet", "co3d", "scannetpp"])
    result = dry_run(tmp_path, config, "paper")
    jobs = planned(result)
    text = result.stdout + result.stderr
    assert not {"objectcentric", "feature_sweep"} & set(jobs)
    assert {"crosscapture", "pose_sources", "handsign", "scorer_arch"} <= set(jobs)
    assert jobs["qualitative"] == 4
    for part in (
        "left out: datasets.scannetpp.root is not set; http",
        "not made: objectcentric.tex: no dataset has `object` scenes",
        "not made: feature_sweep.tex: trials.scenes.feature_sweep is",
    ):
        assert text.count(part) == 1, part
    # the sweep is of all datasets, or refused
    assert "datasets.scannetpp.root is not set" in refusal(tmp_path, config)


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
