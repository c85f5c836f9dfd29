"""Names of folders in a config that lead out of where they belong, and sizes beyond sense."""

import pytest
from dry_runs import experiment, with_dataset

from fsel.workflow.refusal import Refusal


@pytest.mark.parametrize("name", ["../x", "a/../b", "/etc", ".", ".."])
def test_a_scene_lies_in_its_root(name, tmp_path):
    def scenes(names):
        datasets = with_dataset(root=str(tmp_path), scenes={"evaluation": names})
        return experiment(datasets=datasets).scenes("mine", "evaluation")

    with pytest.raises(Refusal, match="does not match"):
        scenes([name])
    inside = ["apple/110_1", "..x", "x.y"]
    for folder in inside:
        (tmp_path / folder).mkdir(parents=True)
    assert scenes(inside) == inside


@pytest.mark.parametrize("results", ["../../x", "..", "a/../../b"])
def test_results_do_not_lead_upwards(results):
    with pytest.raises(Refusal, match="does not match"):
        experiment(pathvars={"results": results})
    experiment(pathvars={"results": "/scratch/a..b"})


def test_images_have_a_largest_size():
    with pytest.raises(Refusal, match="maximum of 16384"):
        experiment(long_side=1e9)
