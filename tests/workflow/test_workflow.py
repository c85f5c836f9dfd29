"""The workflow's plans and its refusals, by dry runs."""

import re

import pytest
import yaml
from dry_runs import ROOT, changed, dry_run, planned, with_dataset

FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """Rule -> number of jobs of the smoke config."""
    folder = tmp_path_factory.mktemp("usual")
    return planned(dry_run(folder, changed(folder)))


def test_default_config_plans_every_job(tmp_path):
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    scenes = [
        entry["scenes"] for entry in config["datasets"].values() if "object" not in entry["scenes"]
    ]
    evaluation = sum(entry["evaluation"] for entry in scenes)
    labelled = config["datasets"]["dl3dv"]["scenes"]
    jobs = planned(dry_run(tmp_path, ROOT / "config" / "config.yaml"))
    # other datasets' scenes to train on and to validate are for other tables alone
    labels = labelled["train"] + labelled["validation"]
    assert jobs["generate"] == jobs["ingest"] == jobs["describe"] == evaluation + labels
    assert jobs["split_labelled"] == jobs["features_labelled"] == jobs["label"] == labels
    assert jobs["split"] == jobs["features"] == jobs["select"] == jobs["evaluate"] == evaluation
    assert jobs["train"] == jobs["train_no_appearance"] == 1
    assert jobs["ksweep"] == jobs["heatmap"] == jobs["order"] == 1


def test_the_study_is_made_when_asked_for(tmp_path, usual):
    table = "results/smoke/tables/speed_error.csv"
    asked = planned(dry_run(tmp_path, changed(tmp_path), table))
    assert asked["speed_error"] == usual["ksweep"] == 1
    assert "speed_error" not in usual


def test_the_papers_experiments_are_made_when_asked_for(tmp_path, usual):
    asked = planned(dry_run(tmp_path, changed(tmp_path), "paper"))
    once = {"handsign", "seedvar", "ga_vs_learned", "pipeline_figure", "teaser"}
    once |= {"time_quality", "feature_sweep", "scorer_arch", "transfer", "reconchoice"}
    once |= {"crosscapture", "objectcentric", "real_world", "measure_costs", "evaluate_geometry"}
    once |= {"evaluate_searched"}  # of the held-out training dataset alone
    once |= {"select_crosscapture", "evaluate_crosscapture"}  # of rooms filmed in several passes
    once |= {"evaluate_feature_sweep", "evaluate_scorer_arch"}  # of one validation scene
    assert {name for name, n in asked.items() if n == 1} >= once
    twice = ("qualitative", "select_objects", "evaluate_objects")
    assert [asked[name] for name in twice] == [2] * 3
    # of the held-out training dataset's one scene, by three reconstructors
    assert (asked["evaluate_transfer"], asked["evaluate_reconchoice"]) == (3, 6)  # of two draws
    assert (asked["trial_feature_sweep"], asked["trial_scorer_arch"]) == (43, 17)
    assert not {"handsign", "trial_scorer_arch", "transfer"} & set(usual)


def test_a_further_reconstructor_adds_evaluations_and_tables_and_no_selection(tmp_path, usual):
    both = planned(dry_run(tmp_path, changed(tmp_path, reconstruction=[FIRST, SECOND])))
    added = {rule: n for rule, n in (both - usual).items() if rule != "total"}
    assert added == {"evaluate": 2, "ksweep": 1, "table_page": 1, "heatmap": 1}
    assert not usual - both


def test_its_tables_lie_in_a_folder_of_its_name_and_are_of_the_same_picks(tmp_path):
    config = changed(tmp_path, reconstruction=[FIRST, SECOND, SECOND | {"as": "g.2"}])
    names = ["ga_vs_learned", "feature_sweep", "scorer_arch", "ksweep"]
    wanted = [*(f"g.2/{name}.tex" for name in names), "gaussians/handsign.tex"]
    asked = planned(dry_run(tmp_path, config, *(f"results/smoke/tables/{w}" for w in wanted)))
    assert asked["evaluate"] == 4
    assert asked["handsign"] == asked["ksweep"] == 1
    assert asked["evaluate_searched"] == asked["search_oracle"] == 1
    unknown = dry_run(tmp_path, config, "results/smoke/tables/other/ksweep.tex")
    assert "MissingRuleException" in unknown.stdout + unknown.stderr


def test_real_captures_are_tried_with_the_default_selectors():
    default, captures = (
        yaml.safe_load((ROOT / "config" / f"{name}.yaml").read_text())
        for name in ("config", "captures")
    )
    assert captures.get("training") == default.get("training")
    for name, dataset in default["datasets"].items():
        if "object" in dataset["scenes"]:
            continue
        scenes = {role: n for role, n in dataset["scenes"].items() if role != "evaluation"}
        assert captures["datasets"][name] == dataset | {"scenes": scenes}


def test_a_dataset_on_disk_is_one_entry(tmp_path, usual):
    (tmp_path / "raw" / "garden").mkdir(parents=True)
    datasets = with_dataset(layout="colmap", root="raw", scenes=["garden"])
    more = planned(dry_run(tmp_path, changed(tmp_path, datasets=datasets)))
    assert more["generate"] == usual["generate"]
    assert more["ingest"] == usual["ingest"] + 1
    assert more["evaluate"] == usual["evaluate"] + 1


def test_the_library_imports_no_snakemake_but_where_its_jobs_are_forked():
    sources = (ROOT / "src").rglob("*.py")
    pattern = re.compile(r"^\s*(?:import|from) snakemake", re.M)
    assert [path.name for path in sources if pattern.search(path.read_text())] == ["forks.py"]


def test_rules_files_declare_rules_and_define_nothing():
    for path in (ROOT / "workflow" / "rules").glob("*.smk"):
        if path.name == "common.smk":
            continue
        assert not re.search(r"^(?:def|class|import|from) ", path.read_text(), re.M), path
