"""The scenes of tables, and what a configuration without them is told."""

from types import SimpleNamespace

import pytest
from dry_runs import ROOT, SMOKE, experiment, with_dataset

from fsel.workflow import cases, scenes
from fsel.workflow.schema import Refusal

SCENE = SimpleNamespace(dataset="dl3dv", scene="evaluation00")


def test_rooms_are_filmed_in_several_passes():
    made = experiment()
    assert scenes.rooms(made) == [("seven_scenes", "evaluation00")]
    named = experiment(crosscapture={"held_out": {"dl3dv": {"evaluation00": ["a"]}}})
    assert scenes.rooms(named) == [("dl3dv", "evaluation00")]
    assert scenes.passes(named, SCENE) == ["a"]
    unknown = experiment(crosscapture={"held_out": {"dl3dv": {"x": ["a"]}}})
    with pytest.raises(Refusal, match=r"\['dl3dv/x'\] are no evaluation scenes"):
        scenes.rooms(unknown)
    alone = {name: SMOKE["datasets"][name] for name in ("dl3dv", "co3d")}
    with pytest.raises(Refusal, match="no dataset with evaluation scenes was filmed"):
        scenes.rooms(experiment(datasets=alone))


@pytest.mark.parametrize(
    ("changes", "part"),
    [
        ({"search": SMOKE["search"] | {"k": 7}}, r"search.k is 7, .* budgets \[5, 10\]"),
        ({"oracle": {"draws": 0}}, "oracle.draws is 0"),
    ],
)
def test_a_comparison_with_a_search_that_is_not_run_is_refused(changes, part):
    with pytest.raises(Refusal, match=part):
        scenes.held_out_problems(experiment(**changes))


def test_the_search_is_compared_on_scenes_of_one_dataset_or_of_all():
    made, every = experiment(), experiment(oracle={"everywhere": True})
    assert scenes.searched(made) == scenes.held_out(made)
    named = scenes.held_out_problems(every, scenes.searched)
    assert named == [f"{d}/{s}/draw0" for d, s in every.evaluation_scenes]
    assert scenes.held_out_problems(every) == made.searched_problems() == named[:1]


def test_a_second_source_of_poses_is_a_folder_in_each_scene(tmp_path):
    (tmp_path / "a").mkdir()
    datasets = with_dataset(root=str(tmp_path), scenes=["a"])

    def chosen(**settings):
        return scenes.posed_twice(experiment(datasets=datasets, pose_sources=settings))

    for settings, part in (
        ({}, "pose_sources.dataset is None"),
        ({"dataset": "dl3dv"}, "'dl3dv', no dataset with a `root`"),
        ({"dataset": "mine"}, "no folder in 1 of 1 scenes of mine"),
        ({"dataset": "dl3dv", "poses": "colmap"}, "whose images are generated and small"),
        ({"dataset": "mine", "poses": {"by": ["nothing"]}}, "poses: .*no program 'nothing' in"),
    ):
        with pytest.raises(Refusal, match=part):
            chosen(**settings)
    assert chosen(dataset="mine", poses={"by": ["true"]}) == [("mine", "a")]
    (tmp_path / "a" / "vggt").mkdir()
    assert chosen(dataset="mine") == [("mine", "a")]


def test_cases_are_those_of_the_lists():
    made = experiment()
    features, scorers = cases.feature_cases(made), cases.scorer_cases(made)
    rows = (ROOT / "config" / "feature_sweep.csv").read_text().splitlines()[1:]
    assert list(features) == [row.split(",")[0] for row in rows]
    assert list(cases.scorer_labels(made)) == list(scorers)
    every = next(iter(features.values()))
    assert all(case["shown"] == every["shown"] for case in scorers.values())
    assert scenes.tried(made, "scorer_arch") == [("dl3dv", "validation00")]
    elsewhere = experiment(trials={"scenes": {"scorer_arch": {"nowhere": "evaluation"}}})
    with pytest.raises(Refusal, match=r"trials\.scenes\.scorer_arch is .*, of which no scene"):
        scenes.tried(elsewhere, "scorer_arch")
