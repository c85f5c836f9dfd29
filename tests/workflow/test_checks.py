"""Configurations whose parts do not fit together are refused by name, with a hint."""

import pytest
from dry_runs import SMOKE, experiment, with_dataset

from fsel.workflow.refusal import Refusal


def refused(**changes) -> str:
    with pytest.raises(Refusal) as refusal:
        experiment(**changes).check()
    text = str(refusal.value)
    assert text.startswith("config: ")
    assert "\nHint: " in text
    return text


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"budgets": [5, 50]}, ["embedded.frames is 60", "need 62", "lower targets"]),
        ({"search": {"kept": 5, "stored": 4}}, ["search: kept is 5", "more than stored, 4"]),
        ({"search": {"farthest": 30, "uniform": 20}}, ["farthest and uniform are 30 and 20", "40"]),
        ({"training": {"dataset": "other"}}, ["training.dataset is 'other'", "dl3dv"]),
    ],
)
def test_numbers_and_names_that_do_not_fit(changes, parts):
    text = refused(**changes)
    for part in parts:
        assert part in text


@pytest.mark.parametrize(
    ("entry", "parts"),
    [
        ({"root": ".", "scenes": ["a"]}, ["no folders ['a'] in .", "the folders there are"]),
        ({"scenes": ["a"]}, ["exactly one of `embedded`, `root` and `fetch`, got []"]),
        ({"fetch": None, "scenes": ["a"]}, ["exactly one of", "got ['fetch']"]),
        (
            {"fetch": "mipnerf360", "root": ".", "scenes": ["a"]},
            ["got ['fetch', 'root']", "`fetch: null`"],
        ),
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
        (
            {"root": ".", "scenes": [], "protocol": "no.json"},
            ["datasets.mine.protocol is no.json, not a file"],
        ),
        (
            {"root": ".", "scenes": [], "protocol": __file__},
            ["one draw of targets", "layout colmap and draws 2", "`draws: 1`"],
        ),
        ({"root": ".", "scenes": [], "poses": "file"}, ["datasets.mine.poses", "`model`"]),
        (
            {"root": ".", "scenes": [], "reading": {"focal": 1.2}},
            ["reading.focal: layout colmap", "only tanks_and_temples does"],
        ),
        ({"root": ".", "scenes": {"train": ["a"], "object": ["a"]}}, ["names a scene twice"]),
        (
            {"embedded": {"family": "dl3dv"}, "layout": "auto", "scenes": {"train": 1}},
            ["datasets.mine.layout is `auto`"],
        ),
    ],
)
def test_a_wrong_dataset(tmp_path, monkeypatch, entry, parts):
    monkeypatch.chdir(tmp_path)
    text = refused(datasets=with_dataset(**({"layout": "colmap"} | entry)))
    for part in parts:
        assert part in text


def test_a_folder_takes_the_place_of_a_download(tmp_path):
    (tmp_path / "garden").mkdir()
    entry = {"fetch": None, "root": str(tmp_path), "layout": "mipnerf360", "scenes": ["garden"]}
    made = experiment(datasets=with_dataset(**entry))
    made.check()
    assert made.datasets.raw_capture("mine", "garden") == str(tmp_path / "garden")
    assert "mine" not in made.datasets.names("fetch")


def test_scannet_scenes_need_an_object_each(tmp_path):
    for scene in ("kitchen", "office"):
        (tmp_path / scene).mkdir()
    entry = {"layout": "scannet", "root": str(tmp_path)}
    entry |= {"scenes": {"object": ["kitchen", "office"]}}
    for instance in ({}, {"instance": {"kitchen": 4}}):
        text = refused(datasets=with_dataset(**entry, reading=instance))
        assert "datasets.mine.reading.instance: no object of" in text
        assert "'office'" in text
    reading = {"instance": {"kitchen": 4, "office": 7}}
    made = experiment(datasets=with_dataset(**entry, reading=reading))
    made.check()
    assert made.datasets.reading("mine", "office")["reading"] == {"instance": 7}


def test_frames_that_a_scene_needs():
    made = experiment()
    assert made.frames_needed("evaluation") == 2 * 6 + 10
    assert made.frames_needed("object") == 2 * 6 + 10
    # 9 targets at 60 % coverage and 5 of the search; refinement needs 2 * 6 + 10
    assert made.frames_needed("train") == max(2 * 9 + 5, 22)
    unrefined = experiment(refinement=SMOKE["refinement"] | {"seeds": 0}, coverages=[25])
    assert unrefined.frames_needed("train") == 2 * 4 + 5
