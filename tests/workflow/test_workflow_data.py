"""The workflow's door to data: fetched, on disk, missing or damaged."""

import hashlib
import os
import re
import shutil
import threading
from collections import Counter
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from os.path import relpath
from pathlib import Path

import pytest
import yaml
from dry_runs import dry_run, experiment, forked, planned, refusal
from layout_recordings import recording
from snakemake.utils import update_config

from fsel.captures.layouts import LAYOUTS
from fsel.workflow.paper import Paper

ROOT = Path(__file__).parents[2]
PAPER = yaml.safe_load((ROOT / "config" / "paper.yaml").read_text())
STAND_INS = ROOT / "config" / "stand_ins.yaml"


def run(folder, *arguments):
    words = ["--snakefile", str(ROOT / "Snakefile"), "--cores", "1", *arguments]
    words += [] if "--configfile" in arguments else ["--configfile", "config.yaml"]
    return forked(folder, *words, "--workflow-profile", str(ROOT / "profiles" / "default"))


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
    assert "f20.jpg: image file is empty" in result.stdout + result.stderr
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
    image = tmp_path / "zip" / "garden" / "images_4" / "f20.jpg"
    sums = {"images_4/f20.jpg": hashlib.sha256(image.read_bytes()).hexdigest()}
    archive = {"url": f"{address}/both.zip", "licence": "CC0"}
    table = {name: archive | {"inside": name} for name in ("garden", "hall")}
    table["garden"]["files"] = sums
    source = {"page": address, "expects": "", "scenes": table}
    (tmp_path / "sources.yaml").write_text(yaml.safe_dump({"here": source}))
    entry = {"label": "Mine", "fetch": "here", "scenes": {"evaluation": 2}}
    results = smoke_with(tmp_path, entry, targets=4, sources="sources.yaml")
    targets = [f"{results}/{name}/images.npy" for name in table]
    result = run(tmp_path, *targets)
    assert result.returncode == 0, result.stdout + result.stderr
    assert all((tmp_path / target).is_file() for target in targets)
    assert (tmp_path / "downloads" / "here_both.zip").is_file()
    log = tmp_path / "results" / "smoke" / "logs" / "unpack" / "mine" / "hall.log"
    assert "licence: CC0" in log.read_text()
    again = run(tmp_path, *targets)
    assert "Nothing to be done" in again.stdout + again.stderr


def paper_config(folder, absent=(), stand_ins=True, allowed=False, most=99):
    """The paper's config over folders of the right shape, those of some datasets left out."""
    config = yaml.safe_load((ROOT / "config" / "paper.yaml").read_text())
    config["allow_missing"] = allowed
    for name, entry in config["datasets"].items():
        if "root" not in entry or name in absent:
            continue
        if isinstance(scenes := entry["scenes"], dict):
            scenes = entry["scenes"] = {role: min(n, most) for role, n in scenes.items()}
        entry["root"] = name
        found = scenes if isinstance(scenes, list) else range(sum(scenes.values()))
        for scene in found:
            (folder / name / str(scene)).mkdir(parents=True)
        if name == "scannet":
            entry["reading"] = {"instance": {str(scene): 1 for scene in found}}
        if name == config["pose_sources"]["dataset"]:
            for scene in range(scenes["evaluation"]):
                (folder / name / str(scene) / config["pose_sources"]["model"]).mkdir(parents=True)
    if stand_ins:
        update_config(config, yaml.safe_load(STAND_INS.read_text()))
    (folder / "paper.yaml").write_text(yaml.safe_dump(config))
    return folder / "paper.yaml"


def test_what_the_paper_s_config_lacks_is_told_on_one_page(tmp_path):
    text = refusal(tmp_path, paper_config(tmp_path, absent=["co3d", "scannet"], stand_ins=False))
    (page,) = re.findall(r"^config: no folders .*?^Hint: ", text, re.M | re.S)
    for part in (
        "git clone https://github.com/arthurhero/Long-LRM",
        "./programs/long_lrm_i540.pt",
        "transfer.reconstructions, nerfacto",
        "reconchoice.reconstructions, anysplat",
        "'programs/vit_small_patch14_dinov2.safetensors'",
        f"snakemake paper --cores 2 --configfile paper.yaml {relpath(STAND_INS, tmp_path)}",
        "which makes handsign.tex, seedvar.tex, ",
        "left out: datasets.co3d.root is not set",
        "not made: objectcentric: no dataset has `object` scenes",
    ):
        assert page.count(part) == 1, part
    assert page.count("no program 'conda' in") == 1


def test_where_all_is_there_the_paper_s_config_plans_every_table_and_wants_a_gpu(
    tmp_path, monkeypatch
):
    """Programs, weights and packages as far as the check looks; the GPUs are the cluster's."""
    config = paper_config(tmp_path, stand_ins=False)
    environments = [f"envs/{name}/bin/python" for name in ("nerfstudio", "gsplat", "ffgs")]
    for name in ("bin/conda", "bin/sbatch", *environments):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
    (tmp_path / "packages" / "timm").mkdir(parents=True)
    (tmp_path / "packages" / "timm" / "__init__.py").touch()
    (section,) = PAPER["reconstruction"]
    weights = [PAPER["appearance"]["weights"]]
    for file in [*weights, *section["settings"]["files"]]:
        file = tmp_path / file.removeprefix("{here}/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "packages"), prepend=os.pathsep)
    result = dry_run(tmp_path, config, "all", "paper")
    jobs = planned(result)
    assert "can be made" not in result.stdout + result.stderr
    assert set(Paper(experiment()).needs()) <= set(jobs)
    counts = {"ingest": 103 + 90 + 30 + 20, "label": 5 * 90, "select": 103, "evaluate": 103}
    counts |= {"search_oracle": 21, "unpack": 16, "download": 9, "generate": 0}
    counts |= {"select_crosscapture": 6, "select_objects": 20, "qualitative": 6}
    counts |= {"select_paired": 21, "evaluate_paired": 21, "evaluate_scorer_arch": 21}
    counts |= {"evaluate_feature_sweep": 30}
    assert {name: jobs[name] for name in counts} == counts
    (tmp_path / "bin" / "sbatch").unlink()
    for name in ("bash", "which"):
        (tmp_path / "bin" / name).symlink_to(shutil.which(name))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))  # this machine may have another sbatch
    assert "nvidia-smi" in refusal(tmp_path, config)


def test_the_paper_s_config_has_the_paper_s_scenes():
    numbers = Counter()
    for entry in PAPER["datasets"].values():
        scenes = entry["scenes"]
        numbers.update({"evaluation": len(scenes)} if isinstance(scenes, list) else scenes)
    # the paper's tables of scene counts: 21, 6, 9, 30, 30, 7; 30 of ScanNet++ for features; objects
    assert numbers == {"evaluation": 103, "validation": 50, "train": 70, "object": 20}


def test_what_cannot_be_made_of_the_paper_is_listed_and_blocks_nothing_else(tmp_path):
    absent = ["tanks_and_temples", "scannet", "co3d", "scannetpp"]
    config = paper_config(tmp_path, absent, allowed=True, most=3)
    result = dry_run(tmp_path, config, "paper")
    jobs = planned(result)
    text = result.stdout + result.stderr
    assert not {"objectcentric", "feature_sweep"} & set(jobs)
    assert {"crosscapture", "pose_sources", "handsign", "scorer_arch"} <= set(jobs)
    assert jobs["qualitative"] == 4
    for part in (
        "left out: datasets.scannetpp.root is not set; http",
        "not made: objectcentric: no dataset has `object` scenes",
        "not made: feature_sweep: trials.scenes.feature_sweep is",
    ):
        assert text.count(part) == 1, part
