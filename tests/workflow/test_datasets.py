"""Datasets of a configuration: what is there, and errors that name the key and the value."""

import copy
from types import SimpleNamespace

import pytest
from dry_runs import ROOT, SMOKE, experiment, with_dataset

from fsel.workflow.experiment import Experiment
from fsel.workflow.schema import Refusal


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"budgets": [5, 50]}, ["embedded.frames is 60", "need 62"]),
        ({"search": {"kept": 5, "stored": 4}}, ["kept is 5", "stored, 4"]),
        ({"hold_out": {"every": 8}}, ["draws is 2", "hold_out.every"]),
        ({"hold_out": {"every": 8, "first": 5}, "draws": 1}, ["hold_out.first is 5", "is 5"]),
        ({"training": {"dataset": "other"}}, ["training.dataset is 'other'", "dl3dv"]),
        ({"long_side": 1e9}, ["long_side", "maximum of 16384"]),
        ({"pathvars": {"results": "../../x"}}, ["pathvars.results", "'../../x'"]),
        ({"pathvars": {"results": ".."}}, ["pathvars.results", "'..'"]),
        ({"pathvars": {"results": "a/../../b"}}, ["pathvars.results", "'a/../../b'"]),
    ],
)
def test_numbers_and_names_that_do_not_fit(changes, parts):
    with pytest.raises(Refusal) as refused:
        experiment(**changes).check()
    assert all(part in str(refused.value) for part in parts), refused.value


def test_results_may_lie_anywhere_else():
    experiment(pathvars={"results": "/scratch/a..b"})


@pytest.mark.parametrize(
    ("entry", "parts"),
    [
        ({"root": ".", "scenes": ["a"]}, ["no ['a'] in .", "those there are"]),
        ({"scenes": ["a"]}, ["exactly one of `embedded`, `root` and `fetch`, got []"]),
        ({"fetch": None, "scenes": ["a"]}, ["exactly one of", "got ['fetch']"]),
        ({"fetch": "mipnerf360", "root": ".", "scenes": ["a"]}, ["got ['fetch', 'root']"]),
        ({"root": ".", "scenes": {"evaluation": 2}}, ["2 scenes", "mine.scenes"]),
        ({"fetch": "kitti", "scenes": ["a"]}, ["'kitti'", "mipnerf360"]),
        ({"fetch": "scannetpp_dslr", "scenes": ["a"]}, ["https://scannetpp.mlsg.cit.tum.de"]),
        ({"fetch": "mipnerf360", "scenes": ["barn"]}, ["['barn']", "treehill"]),
        ({"root": ".", "scenes": [], "poses": "file"}, ["'model'"]),
        ({"root": ".", "scenes": {"train": ["a"], "object": ["a"]}}, ["names a scene twice"]),
        (
            {"embedded": {"family": "dl3dv"}, "layout": "auto", "scenes": {"train": 1}},
            ["datasets.mine.layout", "'auto'"],
        ),
        (
            {"embedded": {"family": "dl3dv"}, "scenes": {"train": ["a"]}},
            ["datasets.mine.scenes.train", "['a']"],
        ),
        *(({"root": ".", "scenes": [name]}, [f"'{name}'"]) for name in ("../x", "/etc", "..")),
        ({"root": ".", "scenes": ["a/../b"]}, ["'a/../b'"]),
        ({"root": "..", "scenes": ["b/c"]}, ["no ['b/c'] in .."]),
    ],
)
def test_a_wrong_dataset(tmp_path, monkeypatch, entry, parts):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(Refusal, match=r"datasets\.mine") as refused:
        experiment(datasets=with_dataset(**({"layout": "colmap"} | entry))).check()
    assert all(part in str(refused.value) for part in parts), refused.value


def test_a_folder_takes_the_place_of_a_download(tmp_path):
    (tmp_path / "garden").mkdir()
    entry = {"fetch": None, "root": str(tmp_path), "layout": "mipnerf360", "scenes": ["garden"]}
    made = experiment(datasets=with_dataset(**entry))
    wildcards = SimpleNamespace(dataset="mine", scene="garden")
    assert made.datasets.raw_capture(wildcards) == str(tmp_path / "garden")
    assert "mine" not in made.datasets.names("fetch")


def test_counted_scenes_are_disjoint_and_in_natural_order(tmp_path):
    for number in range(1, 13):
        (tmp_path / f"s{number}").mkdir()
    entry = {"root": str(tmp_path), "scenes": {"train": 2, "evaluation": 9, "object": ["s12"]}}
    made = experiment(datasets=with_dataset(**entry))
    assert made.scenes("mine", "evaluation") == [f"s{n}" for n in range(1, 10)]
    assert made.scenes("mine", "train") == ["s10", "s11"]
    assert made.datasets.role_of("mine", "s10") == "train"


def test_scenes_of_several_roots_take_turns_and_are_named_by_both_folders(tmp_path):
    for folder in ("apple/1_b", "apple/2_a", "ball/1_c"):
        (tmp_path / folder).mkdir(parents=True)
    entry = {"root": [str(tmp_path / name) for name in ("apple", "ball")]}
    entry |= {"scenes": {"object": 2, "evaluation": ["apple-2_a"]}}
    made = experiment(datasets=with_dataset(**entry))
    assert made.scenes("mine", "object") == ["apple-1_b", "ball-1_c"]
    wildcards = SimpleNamespace(dataset="mine", scene="apple-2_a")
    assert made.datasets.raw_capture(wildcards) == str(tmp_path / "apple" / "2_a")
    (tmp_path / "ball" / "frame_annotations.jgz").touch()
    with pytest.raises(Refusal, match=r"\['apple-2_a', 'apple-1_b'\] .* co3d"):
        experiment(datasets=with_dataset(**entry, layout="co3d"))
    entry["root"][1] += "s"
    assert "balls" in experiment(datasets=with_dataset(**entry)).datasets.missing["mine"]


def test_scannet_scenes_have_an_object_each(tmp_path):
    for scene in ("kitchen", "office"):
        (tmp_path / scene).mkdir()
    entry = {"layout": "scannet", "root": str(tmp_path)}
    entry |= {"scenes": {"object": ["kitchen", "office"]}}
    reading = {"instance": {"kitchen": 4, "office": 7}}
    made = experiment(datasets=with_dataset(**entry, reading=reading))
    wildcards = SimpleNamespace(dataset="mine", scene="office")
    assert made.datasets.reading(wildcards)["reading"] == {"instance": 7}


def test_a_missing_dataset_is_left_out_and_named_in_captions(tmp_path):
    entry = {"label": "Gone", "root": str(tmp_path / "nowhere"), "scenes": ["a"]}
    made = experiment(datasets=SMOKE["datasets"] | {"gone": entry})
    assert "gone" not in made.datasets.entries
    assert made.facts()["missing"] == ["Gone"]
    assert str(tmp_path / "nowhere") in made.datasets.missing["gone"]
    # a job elsewhere does not see the folder of a run that has it
    config = copy.deepcopy(SMOKE | {"datasets": {"gone": entry}})
    job = Experiment.load(config, ROOT.joinpath, asks=False)
    assert job.evaluation_scenes == [("gone", "a")]
    config["allow_missing"] = True
    assert Experiment.load(config, ROOT.joinpath, asks=False).evaluation_scenes == []


def test_frames_that_a_scene_needs():
    made = experiment()
    assert made.frames_needed("evaluation") == 2 * 6 + 10
    assert made.frames_needed("object") == 2 * 6 + 10
    # 9 targets at 60 % coverage and 5 of the search
    assert made.frames_needed("train") == 2 * 9 + 5
    assert experiment(coverages=[25]).frames_needed("train") == 2 * 4 + 5


@pytest.mark.parametrize(
    ("turns", "levels"),
    [([], [[25, 40, 60]] * 4), ([100], [[100]] * 4), ([60, 60, 25], [[60], [60], [25], [60]])],
)
def test_scenes_take_turns_at_coverage_levels(turns, levels):
    datasets = {"dl3dv": SMOKE["datasets"]["dl3dv"] | {"scenes": {"train": 3, "validation": 1}}}
    datasets["seven_scenes"] = SMOKE["datasets"]["seven_scenes"]
    made = experiment(datasets=datasets, coverages=[60, 25, 40], coverage_turns=turns)
    scenes = ["train00", "train01", "train02", "validation00"]
    assert made.coverages == dict(zip(scenes, levels, strict=True))
