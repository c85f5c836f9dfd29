"""What rules get from the checked configuration."""

import copy
import zlib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from dry_runs import SMOKE, experiment, with_dataset

from fsel.evaluation import latex
from fsel.workflow import inputs, scenes
from fsel.workflow.schema import Refusal

FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}
SCENE = SimpleNamespace(dataset="dl3dv", scene="evaluation00", reconstructor="")


def test_scenes_and_problems():
    made = experiment()
    assert made.evaluation_scenes == [("dl3dv", "evaluation00"), ("seven_scenes", "evaluation00")]
    assert made.problems(1) == ["dl3dv/evaluation00/draw0", "seven_scenes/evaluation00/draw0"]
    assert len(made.problems()) == 4
    assert made.labelled == {"train00": "train", "validation00": "validation"}
    assert made.searched_problems() == ["dl3dv/evaluation00/draw0"]
    assert made.labels() == {"dl3dv": "DL3DV", "seven_scenes": "7-Scenes"}


def test_seeds_come_from_names():
    made = experiment(seed=7)
    assert made.scene_seed(SCENE, "select", 1) == zlib.crc32(b"7/dl3dv/evaluation00/select/1")
    assert made.draw_seeds(SCENE)[1] == made.scene_seed(SCENE, "select", 1)
    assert made.training_seed(SCENE) == zlib.crc32(b"7/dl3dv/evaluation00")


def test_a_dataset_may_have_a_number_of_frames_of_its_own():
    datasets = copy.deepcopy(SMOKE["datasets"])
    datasets["seven_scenes"]["embedded"]["frames"] = 20
    made = experiment(datasets=datasets)
    assert [made.embedded_frames(name) for name in ("dl3dv", "seven_scenes")] == [60, 20]
    with pytest.raises(Refusal, match="frames is 20, the evaluation scenes of seven_scenes need"):
        made.check()


def test_without_scenes_to_train_on_the_shipped_scorers_are_measured(tmp_path):
    (tmp_path / "a").mkdir()
    mine = {"mine": {"label": "Mine", "root": str(tmp_path), "scenes": ["a"]}}
    made = experiment(datasets=mine, training={"dataset": "elsewhere"})
    made.check()
    names = [scorer.rsplit("/")[-1] for scorer in made.scorers(SCENE)]
    own = ["less_is_more.0.safetensors", "less_is_more_no_appearance.0.safetensors"]
    assert names == [*own, "fsel.0.json", "fsel_rule.0.json"]
    assert (made.trained, made.labelled) == ("mine", {})
    with pytest.raises(Refusal, match="no dataset has `train` scenes"):
        scenes.with_labels(made)
    named = {"weights": {"less_is_more": ["own.safetensors"]}}
    made = experiment(datasets=mine, training=named)
    assert made.given_scorers["less_is_more.0.safetensors"] == "own.safetensors"
    assert made.weights("less_is_more_no_appearance")[0].endswith(own[1])


def test_scorers_are_trained_named_or_shipped():
    made = experiment()
    assert made.weights("less_is_more") == ["<results>/selector/seed0.safetensors"]
    assert made.weights("less_is_more_no_appearance") == [
        "<results>/selector/no_appearance/seed0.safetensors"
    ]
    assert made.fsel == ["<results>/selector/given/fsel.0.json"]
    assert made.scorers(SCENE)[-1] == "<results>/selector/given/fsel_rule.0.json"
    shipped = made.given_scorers["fsel_rule.0.json"]
    assert shipped.endswith("src/fsel/selectors/weights/fsel_rule.json")
    training = SMOKE["training"] | {"weights": {"less_is_more": ["mine.safetensors"]}}
    named = experiment(training=training)
    assert named.given_scorers["less_is_more.0.safetensors"] == "mine.safetensors"
    assert named.weights("less_is_more") == ["<results>/selector/given/less_is_more.0.safetensors"]


def test_scenes_that_are_learned_from_are_measured_by_the_scorers_of_their_fold():
    datasets = copy.deepcopy(SMOKE["datasets"])
    datasets["dl3dv"]["scenes"]["train"] = 4
    datasets["dl3dv"]["places"] = {"train00": "a house", "train03": "a house"}
    made = experiment(datasets=datasets, training=SMOKE["training"] | {"folds": 2})
    assert list(made.folds.values()) == ["fold0/", "fold1/", "fold0/", "fold0/"]
    learned = [("dl3dv", f"train0{number}") for number in range(4)]
    assert made.evaluation_scenes[:5] == [("dl3dv", "evaluation00"), *learned]
    roles = made.roles("fold0/")
    assert [scene for scene, role in roles.items() if role == "train"] == ["train01"]
    assert made.roles("") == made.labelled
    own = SimpleNamespace(dataset="dl3dv", scene="train01")
    assert made.scorers(own)[0] == "<results>/selector/fold1/seed0.safetensors"
    assert made.scorers(own)[1] == "<results>/selector/fold1/no_appearance/seed0.safetensors"
    other = SimpleNamespace(dataset="seven_scenes", scene="train01")
    assert made.scorers(other) == made.scorers(SCENE) == made.scorers(SimpleNamespace())


def test_further_reconstructors_are_folders():
    made = experiment(reconstruction=[FIRST, SECOND, SECOND | {"as": "g.2"}])
    assert made.extra_reconstructors == ["gaussians/", "g.2/"]
    assert made.folders == r"(?:|gaussians/|g\.2/)"
    second = SimpleNamespace(reconstructor="g.2/")
    assert made.reconstruction_of(SCENE)["name"] == "splats"
    assert made.reconstruction_of(second) == SECOND
    assert made.facts_of(second)["reconstructor"] == "g.2 (gaussians)"
    assert made.facts_of(SCENE)["long_side"] == 48
    assert made.searched_by(second) == []
    assert made.searched_by(SCENE) == made.searched_problems()
    with pytest.raises(Refusal, match="reconstruction has two named 'splats'"):
        experiment(reconstruction=[FIRST, FIRST])


def test_labels_may_come_from_another_reconstructor():
    made = experiment(search=SMOKE["search"] | {"reconstruction": SECOND})
    assert made.labeller == SECOND
    assert made.reconstruction["name"] == "splats"
    assert "reconstruction" not in made.config["search"]
    assert experiment().labeller == experiment().reconstruction


def test_searches_keep_their_metric_when_tables_print_another():
    made = experiment(metrics=["psnr", "lpips"], pathvars={"downloads": "kept"})
    assert made.metrics["lpips"] == {"net": "alex", "weights": "kept/lpips_alex.safetensors"}
    assert list(made.fitness) == ["psnr", "ssim", "gmsd"]
    own = {"net": "vgg", "weights": "mine.pth"}
    made = experiment(metrics=["psnr"], fitness="lpips", lpips=own)
    assert made.fitness == {"psnr": {}, "ssim": {}, "lpips": own}
    assert made.metrics == {"psnr": {}}


def test_gmsd_stands_in_the_place_of_lpips_and_captions_say_so():
    made = experiment(metrics=["psnr", "lpips", "gmsd"], fitness="lpips")
    assert "without_lpips" not in made.facts()
    without = replace(made, without_lpips="no network")
    assert without.metrics == {"psnr": {}, "gmsd": {}}
    assert list(without.fitness) == ["psnr", "ssim", "gmsd"]
    for text in (latex.made_by(without.facts()), latex.note(without.facts())):
        assert "GMSD in the place of LPIPS" in text


def test_places_are_shared_by_name_or_by_dataset(tmp_path):
    (tmp_path / "a").mkdir()
    entry = {"root": str(tmp_path), "scenes": ["a"]}
    by_name = with_dataset(**entry, places={"a": "house"})
    assert experiment(datasets=by_name).places() == {"mine/a": "house"}
    by_word = with_dataset(**entry, places="street")
    assert experiment(datasets=by_word).facts()["places"] == {"mine/a": "street/a"}


def test_resources_grow_with_attempts_frames_and_pixels(tmp_path):
    small, large = (experiment(reconstruction={"long_side": side}) for side in (48, 256))
    needed = small.resources(1000, 10)
    assert [needed["mem_mb"](None, attempt=n) for n in (1, 3)] == [1000, 3000]
    grown = [e.resources(1000, 10, "reconstruction") for e in (small, large)]
    assert [n["runtime"](None, input=[], attempt=2) for n in grown] == [20, 80]
    second = {"name": "external", "long_side": 960, "settings": {"serve": ["x"]}}
    external = experiment(reconstruction=[FIRST, second])
    assert external.resources(grows="reconstruction")["runtime"](None, [], 1) == 10


def test_a_gpu_is_asked_for_where_the_reconstructor_uses_one():
    external = SECOND | {"name": "external", "settings": {"serve": ["x"], "gpu": True}}
    made = experiment(reconstruction=[FIRST, external])
    gpu = made.resources(reconstruction=made.reconstruction_of)["gpu"]
    assert gpu(SCENE) is None  # no resource at all
    assert gpu(SimpleNamespace(reconstructor="external/")) == 1
    assert "gpu" not in made.resources()


def test_rules_depend_on_the_reconstructor_that_they_use(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = experiment(reconstruction=[FIRST, SECOND])
    digest = made.library("evaluate", made.reconstruction_of)
    second = SimpleNamespace(reconstructor="gaussians/")
    assert digest(SCENE) == made.library("evaluate") != digest(second)
    fewer = experiment(datasets={"dl3dv": SMOKE["datasets"]["dl3dv"]})
    more = set(fewer.unused("splats")) - set(made.unused("splats"))
    assert any("layouts.co3d" in home for home in more)


def test_finding_poses_takes_longer_than_reading_them_and_may_take_a_gpu(tmp_path):
    (tmp_path / "a").mkdir()
    wildcards = SimpleNamespace(dataset="mine", scene="a")

    def asked(poses):
        made = experiment(datasets=with_dataset(root=str(tmp_path), scenes=["a"], poses=poses))
        return made.ingest_minutes(wildcards, 1), made.ingest_gpus(wildcards)

    assert asked("layout") == (30, None)
    assert asked("colmap") == (240, None)
    assert asked({"by": ["true"], "gpu": True, "timeout": 36_000}) == (600, 1)


def test_inputs_of_the_wildcards_scene_and_of_named_ones():
    assert inputs.of_draws(experiment(), "t.parquet", [3]) == [
        "<results>/{dataset}/{scene}/draw3/t.parquet"
    ]
    assert inputs.captures(["a/b"], ["images"]) == {"images": ["<results>/a/b/images.npy"]}
