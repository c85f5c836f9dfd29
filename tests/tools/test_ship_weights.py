"""Scorers on their way into the package."""

from dataclasses import replace
from pathlib import Path

import pytest

from fsel.selectors import pretrained
from fsel.selectors.scorer import Linear
from ship_weights import ship


def test_what_is_shipped_takes_the_place_of_its_policy(tmp_path):
    """Files lie where the workflow puts them; an error leaves all as it was."""
    given = []
    for name, file in pretrained.FILES.items():
        given.append(tmp_path / f"{name}0{Path(file).suffix}")
        pretrained.method(name).scorer.save(given[-1])
    package = tmp_path / "package"
    package.mkdir()
    ship(given, package)
    for file in pretrained.FILES.values():
        assert (package / file).read_bytes() == (pretrained.FOLDER / file).read_bytes()
    made = {"policy": "less_is_more_geometry", "made by": "a test"}
    other = tmp_path / "no.safetensors"
    replace(pretrained.method("less_is_more").scorer, provenance=made).save(other)
    with pytest.raises(ValueError, match="'less_is_more_geometry'"):
        ship([other, *given], tmp_path)
    Linear({"sharpness": 1.0}, {"policy": "fsel", "made by": "a test"}).save(tmp_path / "no.json")
    with pytest.raises(ValueError, match=r"no\.json: .* sharpness"):
        ship([tmp_path / "no.json"], package)
