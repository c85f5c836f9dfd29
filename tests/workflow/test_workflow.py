"""The workflow's plan and its refusals, by dry runs; scripts stay thin."""

import json
import re

import pytest
import yaml
from dry_runs import ROOT, changed, dry_run, planned, refusal

from fsel.layouts import LAYOUTS


def test_default_config_plans_every_job(tmp_path):
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    scenes = [
        entry["scenes"] for entry in config["datasets"].values() if "object" not in entry["scenes"]
    ]
    evaluation = sum(entry["evaluation"] for entry in scenes)
    labelled = config["datasets"]["dl3dv"]["scenes"]
    jobs = planned(dry_run(tmp_path, ROOT / "config" / "config.yaml"))
    # validation scenes of the other datasets are for the tables of features and scorers alone
    total = sum(entry["train"] + entry["evaluation"] for entry in scenes) + labelled["validation"]
    assert jobs["generate"] == jobs["ingest"] == jobs["describe"] == total
    assert jobs["label"] == labelled["train"] + labelled["validation"]
    assert jobs["select"] == jobs["evaluate"] == evaluation
    assert jobs["split"] == jobs["features"] == evaluation
    assert jobs["train"] == jobs["train_no_appearance"] == 1
    assert jobs["ksweep"] == jobs["heatmap"] == jobs["order"] == 1


ASIDE = ("economy", "budget")


def test_tables_of_speed_are_made_when_asked_for(tmp_path):
    results = "results/smoke"
    targets = [f"{results}/figures/speed_error.pdf"]
    targets += [f"{results}/tables/{name}.tex" for name in ASIDE]
    asked = planned(dry_run(tmp_path, changed(tmp_path), *targets))
    assert asked["selection_time"] == asked["speed_error"] == 1
    assert asked["speed_settings"] == asked["economy"] == 1
    assert (
        asked["select_curves"]
        == asked["evaluate_curves"]
        == asked["fit_budget"]
        == asked["budget"]
        == 1
    )
    assert asked["select_budgets"] == asked["evaluate_budgets"] == 2
    usual = planned(dry_run(tmp_path, changed(tmp_path)))
    assert usual["ksweep"] == 1
    assert not {
        "selection_time",
        "speed_settings",
        "speed_error",
        "economy",
        "budget",
        "fit_budget",
    } & set(usual)


PAPER = {
    "crosscapture",
    "objectcentric",
    "select_objects",
    "evaluate_objects",
    "ingest_masked",
    "handsign",
    "seedvar",
    "ga_vs_learned",
    "training_figure",
    "pipeline_figure",
    "poses",
    "teaser",
    "time_quality",
    "saturation",
    "feature_sweep",
    "scorer_arch",
    "transfer",
    "reconchoice",
    "freedom",
}


def test_the_papers_experiments_are_made_when_asked_for(tmp_path):
    asked = planned(dry_run(tmp_path, changed(tmp_path), "paper"))
    assert set(asked) >= PAPER
    assert asked["evaluate_searched"] == 1  # of the held-out training dataset alone
    assert asked["qualitative"] == 2
    assert (
        asked["select_crosscapture"] == asked["evaluate_crosscapture"] == 1
    )  # of the rooms filmed in several passes
    assert asked["select_objects"] == asked["evaluate_objects"] == asked["ingest_masked"] == 2
    assert asked["measure_costs"] == asked["evaluate_geometry"] == 1
    # of the held-out training dataset's one scene, by three reconstructors
    assert asked["evaluate_transfer"] == asked["evaluate_reconchoice"] == 3
    assert asked["trial"] == 43 + 17
    assert asked["evaluate_trials"] == 2  # of one validation scene, for two tables
    # of each dataset's first evaluation scene, filmed anew with larger images
    assert asked["generate_large"] == asked["select_estimated"] == asked["evaluate_estimated"] == 2
    assert asked["select_noise"] == asked["evaluate_noise"] == 2
    assert not PAPER & set(planned(dry_run(tmp_path, changed(tmp_path))))


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"search": {"k": 7}}, ["search.k is 7", "budgets [5, 10]"]),
        ({"oracle": {"draws": 0}}, ["oracle.draws is 0", "evaluation scenes of training.dataset"]),
    ],
)
def test_a_comparison_with_a_search_that_is_not_run_is_refused(tmp_path, changes, parts):
    search = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())["search"]
    merged = {k: search | v if k == "search" else v for k, v in changes.items()}
    config = changed(tmp_path, **merged)
    result = dry_run(tmp_path, config, "results/smoke/tables/ga_vs_learned.tex")
    assert result.returncode != 0
    for part in [*parts, "Hint: "]:
        assert part in result.stdout + result.stderr
    planned(dry_run(tmp_path, config))


SHIPPED = ROOT / "src" / "fsel" / "selector" / "weights"


def test_scorers_made_elsewhere_are_measured_and_nothing_is_trained(tmp_path):
    names = ("less_is_more", "less_is_more_no_appearance")
    weights = {name: [str(SHIPPED / f"{name}.safetensors")] for name in names}
    smoke = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())["training"]
    both = planned(dry_run(tmp_path, changed(tmp_path, training=smoke | {"weights": weights})))
    assert both["select"] == both["ksweep"] + 1 == 2
    assert not {"label", "order", "train", "train_no_appearance"} & set(both)
    weights.pop("less_is_more_no_appearance")
    one = planned(dry_run(tmp_path, changed(tmp_path, training=smoke | {"weights": weights})))
    assert one["train_no_appearance"] == 1
    assert "train" not in one


@pytest.mark.parametrize(
    ("path", "part"),
    [("nowhere.safetensors", "nowhere.safetensors"), (str(SHIPPED / "fsel.json"), "made for")],
)
def test_scorers_that_are_not_there_or_of_another_policy_are_refused(tmp_path, path, part):
    text = refusal(tmp_path, changed(tmp_path, training={"weights": {"less_is_more": [path]}}))
    for said in ("training.weights.less_is_more", part, "Hint: "):
        assert said in text


def test_without_validation_scenes_features_and_scorers_are_not_compared(tmp_path):
    datasets = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())["datasets"]
    datasets["dl3dv"]["scenes"] = {"train": 1, "evaluation": 1}
    config = changed(tmp_path, datasets=datasets)
    result = dry_run(tmp_path, config, "results/smoke/tables/scorer_arch.tex")
    assert result.returncode != 0
    assert "no dataset has validation scenes" in result.stdout + result.stderr
    planned(dry_run(tmp_path, config))


def test_too_few_frames_to_estimate_are_refused_when_asked_for(tmp_path):
    config = changed(tmp_path, inexact_poses={"frames": 20})
    result = dry_run(tmp_path, config, "results/smoke/tables/poses.tex")
    assert result.returncode != 0
    for part in ["inexact_poses.frames is 20", "needs 22", "Hint: "]:
        assert part in result.stdout + result.stderr
    planned(dry_run(tmp_path, config))


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


def test_a_dataset_on_disk_is_one_entry(tmp_path):
    (tmp_path / "raw" / "garden").mkdir(parents=True)
    smoke = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())
    entry = {"label": "Mine", "layout": "colmap", "root": "raw", "scenes": ["garden"]}
    config = changed(tmp_path, datasets=smoke["datasets"] | {"mine": entry})
    more = planned(dry_run(tmp_path, config))
    base = planned(dry_run(tmp_path, changed(tmp_path)))
    assert more["generate"] == base["generate"]
    assert more["ingest"] == base["ingest"] + 1
    assert more["evaluate"] == base["evaluate"] + 1


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"budgest": [5]}, ["top level", "'budgest' was unexpected", "budgets"]),
        ({"search": {"kay": 5}}, ["search", "'kay' was unexpected"]),
        ({"coverages": [33]}, ["coverages[0]", "33 is not one of [25, 40, 60, 80, 100]"]),
        ({"budgets": [5, 50]}, ["embedded.frames is 60", "need 62", "lower targets"]),
        ({"search": {"kept": 5, "stored": 4}}, ["search: kept is 5", "more than stored, 4"]),
        ({"training": {"dataset": "other"}}, ["training.dataset is 'other'", "dl3dv"]),
    ],
)
def test_a_wrong_value_is_refused_by_name(tmp_path, changes, parts):
    text = refusal(tmp_path, changed(tmp_path, **changes))
    for part in [*parts, "Hint: "]:
        assert part in text


@pytest.mark.parametrize(
    ("entry", "parts"),
    [
        ({"root": "nowhere", "scenes": ["a"]}, ["datasets.mine.root nowhere", "no folders"]),
        ({"root": ".", "scenes": ["a"]}, ["no folders ['a'] in .", "the folders there are"]),
        ({"scenes": ["a"]}, ["exactly one of `embedded`, `root` and `fetch`"]),
        ({"root": ".", "scenes": {"evaluation": 2}}, ["asks for 2 scenes, 0 are there"]),
        (
            {"root": ".", "scenes": {"evaluation": 2, "train": ["a"]}},
            ["datasets.mine.scenes", "a number of scenes for every role"],
        ),
        ({"fetch": "kitti", "scenes": ["a"]}, ["'kitti', which may not", "mipnerf360"]),
        (
            {"fetch": "scannetpp_dslr", "scenes": ["a"]},
            ["may not be downloaded", "https://scannetpp.mlsg.cit.tum.de", "<id>/dslr/", "`root`"],
        ),
        ({"fetch": "mipnerf360", "scenes": ["barn"]}, ["['barn'] are not among", "treehill"]),
        ({"root": ".", "scenes": [], "poses": "file"}, ["datasets.mine.poses", "`model`"]),
        (
            {"root": ".", "scenes": [], "reading": {"focal": 1.2}},
            ["reading.focal: layout colmap", "only tanks_and_temples does"],
        ),
    ],
)
def test_a_wrong_dataset_is_refused_before_any_job(tmp_path, entry, parts):
    smoke = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())
    entry = {"label": "Mine", "layout": "colmap"} | entry
    config = changed(tmp_path, datasets=smoke["datasets"] | {"mine": entry})
    text = refusal(tmp_path, config)
    for part in [*parts, "Hint: "]:
        assert part in text


def test_every_scene_may_have_an_object_of_its_own(tmp_path):
    for scene in ("kitchen", "office"):
        (tmp_path / "raw" / scene).mkdir(parents=True)
    smoke = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())
    entry = {"label": "Mine", "layout": "scannet", "root": "raw"}
    entry |= {"scenes": {"object": ["kitchen", "office"]}}
    masks = "results/smoke/mine/office/masks.npy"
    named = entry | {"reading": {"instance": {"kitchen": 4, "office": 7}}}
    config = changed(tmp_path, datasets=smoke["datasets"] | {"mine": named})
    assert planned(dry_run(tmp_path, config, masks))["ingest_masked"] == 1
    for instance in ({}, {"instance": {"kitchen": 4}}):
        named = entry | {"reading": instance}
        text = refusal(tmp_path, changed(tmp_path, datasets=smoke["datasets"] | {"mine": named}))
        assert "datasets.mine.reading.instance: no object of" in text
        assert "'office'" in text


def test_every_key_of_the_schema_is_described_and_documented():
    schema = yaml.safe_load((ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text())
    documented = (ROOT / "config" / "README.md").read_text()

    def walk(node: dict, path: str) -> None:
        for key, value in node.get("properties", {}).items():
            where = f"{path}{key}"
            assert "description" in value, where
            (row,) = re.findall(rf"^\| `{re.escape(where)}` .*$", documented, re.M)
            assert " ".join(value["description"].split()) in row, where
            if "default" in value and value["default"] and where != "datasets":
                assert f"`{json.dumps(value['default'])}`" in row, where
            if "properties" in value:
                assert value["additionalProperties"] is False, where
                walk(value, f"{where}.")

    walk(schema, "")
    walk(schema["$defs"]["dataset"], "datasets.*.")
    walk(schema["$defs"]["reconstructor"], "reconstruction.")


def test_the_config_takes_every_layout_and_what_its_reader_takes():
    schema = yaml.safe_load((ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text())
    dataset = schema["$defs"]["dataset"]["properties"]
    assert set(dataset["layout"]["enum"]) == {"auto", *LAYOUTS}
    options = {key for layout in LAYOUTS.values() for key in layout.options}
    assert set(dataset["reading"]["properties"]) == options
    common = (ROOT / "workflow" / "rules" / "common.smk").read_text()
    documented = (ROOT / "docs" / "datasets.md").read_text()
    for layout in LAYOUTS.values():
        assert f"| `{layout.name}` |" in documented
        for key in layout.options:
            assert f'"{key}": "{layout.name}"' in common


def test_scripts_are_thin():
    scripts = sorted((ROOT / "workflow" / "scripts").glob("*.py"))
    assert scripts
    for script in scripts:
        assert len(script.read_text().splitlines()) <= 40, script


def test_resources_of_every_rule_grow_with_attempts():
    for path in sorted((ROOT / "workflow" / "rules").glob("*.smk")):
        assert not re.findall(r"(?:mem_mb|runtime)=\d+", path.read_text()), path


def test_only_one_module_knows_snakemake():
    sources = (ROOT / "src").rglob("*.py")
    knowing = {path.name for path in sources if "snakemake" in path.read_text().lower()}
    # the second prints the command to type, the others read how it was typed
    assert knowing == {"job.py", "checksums.py", "command_line.py", "configs.py"}


def test_the_tables_of_arithmetic_are_made_when_asked_for(tmp_path):
    targets = [f"results/smoke/tables/{name}.tex" for name in ("stability", "precision")]
    asked = planned(dry_run(tmp_path, changed(tmp_path), *targets))
    assert asked["stability"] == asked["precision"] == asked["train"] == 1
    assert not {"stability", "precision"} & set(planned(dry_run(tmp_path, changed(tmp_path))))
    alone = planned(dry_run(tmp_path, changed(tmp_path), targets[0]))
    assert set(alone) - {"total"} == {"stability"}


def test_lpips_without_its_weights_is_refused_with_their_page(tmp_path):
    config = changed(tmp_path, metrics=["psnr", "lpips"], lpips={"net": "alex"})
    told = refusal(tmp_path, config)
    assert "lpips.weights is 'None'" in told
    assert "https://download.pytorch.org/models/alexnet-owt-7be5be79.pth" in told
