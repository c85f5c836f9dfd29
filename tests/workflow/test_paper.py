"""The paper's configuration with a person's own part: an overlay, stand-in roots, costs."""

import re

import pytest
import yaml
from dry_runs import ROOT, planned, snakemake
from layout_recordings import recording

from fsel.captures.layouts import LAYOUTS
from fsel.experiments import TABLES

PAPER, STAND_INS = ROOT / "config" / "paper.yaml", ROOT / "config" / "stand_ins.yaml"
CONFIG = yaml.safe_load(PAPER.read_text())
SCENES = {
    "dl3dv": {"evaluation": 1, "validation": 1, "train": 1},
    "scannet_iphone": {"evaluation": 1},
    "scannetpp": {"evaluation": 1, "validation": 1},
    "scannet": {"object": ["scene0000_00"]},
    "co3d": {"object": 1},
}


@pytest.fixture(scope="module")
def overlay(tmp_path_factory):
    """What `snakemake overlay` prints, without what Snakemake says."""
    result = snakemake(tmp_path_factory.mktemp("overlay"), [PAPER], "overlay")
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_the_overlay_is_filled_in_and_changes_nothing_but_roots(overlay):
    content = yaml.safe_load(overlay)
    assert overlay.startswith("# Your own part of a configuration")
    assert list(content["datasets"]) == list(CONFIG["datasets"])
    for name, entry in content["datasets"].items():
        assert entry["root"] == f"/data/{name}"
        assert entry["scenes"] == CONFIG["datasets"][name]["scenes"]
        assert ("fetch" in entry) == ("fetch" in CONFIG["datasets"][name])
    for key in ("reconstruction", "transfer", "reconchoice"):
        given = CONFIG[key] if key == "reconstruction" else CONFIG[key]["reconstructions"]
        own = content[key] if key == "reconstruction" else content[key]["reconstructions"]
        assert own == given
    assert "*id" not in overlay
    assert "&id" not in overlay


def test_the_paper_plans_on_roots_in_all_eight_layouts(overlay, tmp_path):
    """Captures as our own writers write them, and a file of one's own over the tracked ones."""
    content = {"datasets": yaml.safe_load(overlay)["datasets"]}
    layouts = set()
    for name, entry in content["datasets"].items():
        layout = CONFIG["datasets"][name]["layout"]
        entry["root"] = str(tmp_path / "data" / name)
        entry["scenes"] = scenes = SCENES.get(name, entry["scenes"])
        names = (
            [s for found in scenes.values() for s in _named(found)]
            if isinstance(scenes, dict)
            else scenes
        )
        for at, scene in enumerate(names):
            place = tmp_path / "data" / name / (scene if isinstance(scene, str) else f"s{at}")
            LAYOUTS[layout].write(recording(layout), place)
            layouts.add(layout)
        if name == CONFIG["pose_sources"]["dataset"]:
            (tmp_path / "data" / name / "s0" / CONFIG["pose_sources"]["model"]).mkdir(parents=True)
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(content))
    configs = [PAPER, STAND_INS, tmp_path / "mine.yaml"]
    result = snakemake(tmp_path, configs, "--dry-run", "paper")
    jobs = planned(result)
    assert len(layouts) == 8
    assert {name for name, table in TABLES.items() if table.category == "Paper"} <= set(jobs)
    assert jobs["ingest"] == 3 + 6 + 9 + 1 + 2 + 7
    assert jobs["ingest_masked"] == 2
    assert not {"download", "unpack"} & set(jobs)
    text = result.stdout + result.stderr
    assert "can be made" not in text


def _named(found):
    return found if isinstance(found, list) else range(found)


def test_costs_count_jobs_and_hours_served_and_not(tmp_path):
    result = snakemake(tmp_path, [PAPER], "costs")
    assert result.returncode == 0, result.stderr
    rows = dict(re.findall(r"^(\w+ +\w+) +(\d+ .*)$", result.stdout, re.M))
    rows = {" ".join(key.split()): value.split() for key, value in rows.items()}
    # 90 scenes in two jobs each; 5 coverages of 610 subsets; 15 s to load, 2 to fit, 0.3 to render
    assert rows["label long_lrm"][:2] == ["180", "274500"]
    served, alone = map(int, rows["label long_lrm"][2:])
    assert served == round((274_500 * 2.3 + 180 * 15) / 3600)
    assert alone == round(274_500 * 17.3 / 3600)
    assert rows["evaluate long_lrm"][0] == "103"
    assert "243 captures" in result.stdout
    told = snakemake(tmp_path, [PAPER, STAND_INS], "costs")
    assert "splats states no cost" in told.stdout
