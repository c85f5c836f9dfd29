"""What is named and not here is told before any job."""

from threading import Event
from unittest.mock import Mock

import pytest
from dry_runs import ROOT, SMOKE, experiment, with_dataset

from fsel.workflow import requirements
from fsel.workflow.paper import Paper
from fsel.workflow.schema import Refusal

SHIPPED = ROOT / "src" / "fsel" / "selectors" / "weights"
FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}


def check(**changes) -> None:
    Paper(experiment(**changes)).check(["config.yaml"])


def refused(**changes) -> str:
    with pytest.raises(Refusal) as refusal:
        check(**changes)
    assert "\nHint: " in str(refusal.value)
    return str(refusal.value)


def test_a_dataset_that_is_not_there_is_refused_unless_that_is_allowed():
    datasets = with_dataset(layout="dl3dv", root="nowhere", scenes=["a"])
    text = refused(datasets=datasets)
    for part in (
        "no folders (from ",
        "for 1 of 5 datasets:\n  datasets.mine.root nowhere (no folder /",
        "https://huggingface.co/datasets/DL3DV/DL3DV-Benchmark",
        "allow_missing: true",
    ):
        assert part in text
    check(datasets=datasets, allow_missing=True)
    paged = with_dataset(root="nowhere", scenes=["a"], page="https://example.org/captures")
    assert "; https://example.org/captures\n" in refused(datasets=paged)


def test_a_root_may_be_a_variable_of_the_environment(tmp_path, monkeypatch):
    written = "${FSEL_CAPTURES:-nowhere}"
    datasets = with_dataset(root=written, scenes=["a"])
    monkeypatch.delenv("FSEL_CAPTURES", raising=False)
    assert f"datasets.mine.root {written} (no folder /" in refused(datasets=datasets)
    monkeypatch.setenv("FSEL_CAPTURES", str(tmp_path))
    paged = datasets["mine"] | {"page": "https://example.org/captures"}
    with pytest.raises(Refusal, match=r"no .'a'. in .*; https://example\.org/captures"):
        experiment(datasets=datasets | {"mine": paged})
    (tmp_path / "a").mkdir()
    assert experiment(datasets=datasets).datasets.entries["mine"]["root"] == str(tmp_path)
    empty = with_dataset(root="${FSEL_NOT_SET}", scenes=["a"])
    assert "datasets.mine.root is ${FSEL_NOT_SET}, which is empty" in refused(datasets=empty)


def test_a_program_for_poses_that_is_not_there_is_refused(tmp_path):
    (tmp_path / "a").mkdir()
    poses = {"by": [["colmap_nowhere", "mapper"], ["glomap", "mapper"]], "files": {"w": "ask"}}
    text = refused(datasets=with_dataset(root=str(tmp_path), scenes=["a"], poses=poses))
    for part in ("datasets.mine.poses: poses by glomap: w is missing: ask", "'colmap_nowhere' in"):
        assert part in text
    text = refused(datasets=with_dataset(root=str(tmp_path), scenes=["a"], poses={"by": ["a {b}"]}))
    assert "datasets.mine.poses: poses: by has {b} in 'a {b}'; allowed: {folder}" in text


def test_without_the_labelled_dataset_nothing_is_made():
    datasets = SMOKE["datasets"] | {
        "dl3dv": {"label": "DL3DV", "layout": "dl3dv", "root": None, "scenes": {"train": ["a"]}}
    }
    text = refused(datasets=datasets, allow_missing=True)
    assert "datasets.dl3dv.root is not set; https://" in text


@pytest.mark.parametrize(
    ("reconstruction", "parts"),
    [
        ({"settings": {"colour": 1}}, ["reconstruction, splats: reconstructor 'splats'", "colour"]),
        (
            [FIRST, SECOND | {"settings": {"steps": -1}}],
            ["reconstruction, gaussians", "steps", "got -1"],
        ),
    ],
)
def test_settings_that_a_reconstructor_does_not_take(reconstruction, parts):
    text = refused(reconstruction=reconstruction)
    for part in parts:
        assert part in text


def test_lpips_without_its_weights_is_refused():
    text = refused(metrics=["psnr", "lpips"], lpips={"weights": "none.pth"})
    assert "lpips.weights is 'none.pth'" in text
    assert "snakemake paper --cores 2 --configfile config.yaml" in text


@pytest.mark.parametrize(
    ("path", "part"),
    [("nowhere.safetensors", "nowhere.safetensors"), (str(SHIPPED / "fsel.json"), "made for")],
)
def test_scorers_that_are_not_there_or_of_another_policy(path, part):
    text = refused(training=SMOKE["training"] | {"weights": {"less_is_more": [path]}})
    assert "training.weights.less_is_more" in text
    assert part in text


def test_reconstructors_of_a_table_are_checked_when_it_is_asked_for():
    requirements.check_reconstructors({"splats": FIRST | {"settings": {}}}, "transfer")
    with pytest.raises(Refusal, match="transfer, g: reconstructor 'gaussians'"):
        requirements.check_reconstructors({"g": SECOND | {"settings": {"steps": -1}}}, "transfer")


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"exists.side_effect": OSError("AccessDenied")}, "AccessDenied"),
        ({"store_object.side_effect": OSError("AccessDenied")}, "AccessDenied"),
        ({"bucket_exists.return_value": False}, "no such bucket"),
        ({"exists.side_effect": Event().wait}, "no answer"),
    ],
)
def test_a_storage_that_no_job_could_use_is_refused(change, fault, tmp_path):
    usual = {"exists.return_value": False, "local_path.return_value": tmp_path / "fs" / ".fsel"}
    provider = Mock(**{"object.side_effect": [Mock(**usual), Mock(**usual, **change)]})
    requirements.check_storage(provider, "s3://bucket", write=True)
    with pytest.raises(SystemExit, match=f"s3://bucket: .*{fault}"):
        requirements.check_storage(provider, "s3://bucket", write=True, seconds=0.3)
