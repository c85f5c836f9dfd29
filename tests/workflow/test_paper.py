"""The paper's configuration over folders in each dataset's layout."""

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


def test_the_paper_plans_on_roots_in_all_eight_layouts(tmp_path):
    """Captures as our own writers write them, and a file of one's own over the tracked ones."""
    content = yaml.safe_load((ROOT / "config" / "paper_data.yaml").read_text())
    assert list(content["datasets"]) == list(CONFIG["datasets"])
    layouts = set()
    for name, entry in content["datasets"].items():
        layout = CONFIG["datasets"][name]["layout"]
        entry["root"] = str(tmp_path / "data" / name)
        entry["scenes"] = scenes = SCENES.get(name, CONFIG["datasets"][name]["scenes"])
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
