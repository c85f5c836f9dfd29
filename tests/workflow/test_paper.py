"""The paper's tables: what can be made, of what, under which reconstructors, and why not."""

import re
from types import SimpleNamespace

import pytest
import yaml
from dry_runs import ROOT, changed, dry_run, experiment, planned, snakemake
from layout_recordings import recording

from fsel.captures.layouts import LAYOUTS
from fsel.workflow import inputs
from fsel.workflow.functions import LISTED
from fsel.workflow.paper import Paper
from fsel.workflow.refusal import Refusal

PAPER, STAND_INS = ROOT / "config" / "paper.yaml", ROOT / "config" / "stand_ins.yaml"
CONFIG = yaml.safe_load(PAPER.read_text())
FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}
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
    assert set(Paper(experiment()).needs()) <= set(jobs)
    assert jobs["ingest"] == 3 + 6 + 9 + 1 + 2 + 7
    assert jobs["ingest_masked"] == 2
    assert not {"download", "unpack"} & set(jobs)
    text = result.stdout + result.stderr
    assert "can be made" not in text


def _named(found):
    return found if isinstance(found, list) else range(found)


def test_what_is_measured_is_measured_by_the_scheme():
    """The others time a reconstruction, or draw its images."""
    folder = ROOT / "src" / "fsel" / "experiments"
    own = re.compile(r"reconstructor_of\(|RECONSTRUCTORS|Evaluator[.(]|checked_select")
    found = {path.stem for path in folder.rglob("*.py") if own.search(path.read_text())}
    assert found == {"bench", "footprint", "pictures"}


def test_every_table_is_a_rule_under_its_own_name_with_a_caption():
    rules = (ROOT / "workflow" / "rules").glob("*.smk")
    text = "".join(path.read_text() for path in rules)
    assert set(Paper(experiment()).needs()) <= set(LISTED)
    for name in LISTED:
        assert len(re.findall(rf"^use rule \w+ as {name} with:", text, re.M)) == 1, name
    for name in re.findall(r"\*\*shown\(\s*\"(\w+)\"", text):
        assert (ROOT / "workflow" / "report" / f"{name}.rst").is_file(), name


def test_a_further_reconstructor_measures_the_same_picks(tmp_path):
    config = changed(tmp_path, reconstruction=[FIRST, SECOND])
    names = ["candidate_pools", "ga_vs_learned", "feature_sweep", "scorer_arch"]
    targets = [f"results/smoke/tables/gaussians/{name}.tex" for name in names]
    rules = planned(dry_run(tmp_path, config, *targets))
    assert rules["evaluate_candidate_pools"] == rules["select_candidate_pools"] == 2
    assert rules["evaluate_searched"] == rules["search_oracle"] == 1


def test_the_paper_leaves_out_what_cannot_be_made_and_says_why(capsys):
    transfer = {"reconstructions": [{"name": "splats"}], "budgets": [7]}
    paths = Paper(experiment(transfer=transfer)).targets()
    assert "<tables>/handsign.tex" in paths
    assert "<figures>/pipeline.pdf" in paths
    assert "<figures>/qualitative_dl3dv.pdf" in paths
    assert not any("transfer" in path or "reconchoice" in path for path in paths)
    said = capsys.readouterr().err
    assert "paper: of 16 tables and figures" in said
    assert "  not made: transfer: transfer.budgets has [7], which are not among" in said
    assert "  not made: pose_sources: pose_sources.dataset is None" in said


def test_budgets_without_picks_are_refused():
    made = experiment(transfer={"reconstructions": [FIRST], "budgets": [5], "inputs": [5, 6]})
    with pytest.raises(Refusal, match=r"transfer\.inputs has \[6\]"):
        Paper(made).budgets("inputs")


def test_programs_that_a_table_names_must_be_there_when_it_is_made():
    wrong = SECOND | {"settings": {"steps": -1}}
    paper = Paper(experiment(transfer={"reconstructions": [wrong]}))
    for asked in (paper.targets, lambda: paper.library("transfer", "transfer")(None)):
        with pytest.raises(Refusal, match=r"transfer\.reconstructions, gaussians: .*steps"):
            asked()
    in_a_job = Paper(paper.experiment, asks=False)
    assert any(path.endswith("transfer.py") for path in in_a_job.library("transfer", "transfer")(0))


def test_the_report_names_a_further_reconstructor():
    first, further = (SimpleNamespace(reconstructor=name) for name in ("", "g.2/"))
    labels = inputs.report_labels
    assert labels("Drawn", "table")(first) == {"table": "Drawn", "form": "LaTeX"}
    said = {"table": "Drawn, differences, g.2", "form": "numbers"}
    assert labels("Drawn", "differences")(further) == said
    assert labels("Drawn", "figures")(SimpleNamespace()) == {"figure": "Drawn"}
