"""Schemas: names from the registries, defaults, refusals, and the page that describes the keys."""

import copy
import json
import re

import pytest
import yaml
from dry_runs import ROOT, SMOKE

from fsel.captures.layouts import LAYOUTS
from fsel.captures.read import POINTS, POSES
from fsel.features.appearance import KINDS
from fsel.metrics import REGISTERED
from fsel.metrics.published import PICKLES
from fsel.reconstruct import RECONSTRUCTORS
from fsel.synthetic import FAMILIES
from fsel.workflow.schema import Refusal, complete, read_schema

SCHEMA = read_schema(ROOT / "workflow" / "schemas" / "config.schema.yaml")
KEYS = SCHEMA["properties"]
DATASET = SCHEMA["$defs"]["dataset"]["properties"]


def test_lists_of_names_are_those_of_the_registries():
    assert DATASET["layout"]["enum"] == ["auto", *LAYOUTS]
    assert KEYS["metrics"]["items"]["enum"] == list(REGISTERED)
    assert SCHEMA["$defs"]["reconstructor"]["properties"]["name"]["enum"] == list(RECONSTRUCTORS)
    # written out, since their modules take long to import
    assert DATASET["embedded"]["properties"]["family"]["enum"] == list(FAMILIES)
    assert DATASET["poses"]["then"]["enum"] == list(POSES)
    assert DATASET["points"]["enum"] == list(POINTS)
    assert KEYS["appearance"]["properties"]["kind"]["enum"] == list(KINDS)
    assert KEYS["lpips"]["properties"]["net"]["enum"] == list(PICKLES)


def test_every_option_of_a_reader_is_a_key():
    options = {key for layout in LAYOUTS.values() for key in layout.options}
    assert set(DATASET["reading"]["properties"]) == options
    documented = (ROOT / "docs" / "datasets.md").read_text()
    assert all(f"| `{name}` |" in documented for name in LAYOUTS)


def test_a_registry_stands_in_a_list_beside_other_words(tmp_path):
    path = tmp_path / "schema.yaml"
    path.write_text('properties: {a: {enum: [none, "fsel.metrics:REGISTERED", 3]}}')
    assert read_schema(path)["properties"]["a"]["enum"] == ["none", *REGISTERED, 3]


def test_defaults_are_filled_in_within_what_is_given():
    config = {"search": {"k": 7}, "reconstruction": [{"name": "splats"}]}
    complete(config, SCHEMA, "")
    assert config["search"]["k"] == 7
    assert config["search"]["population"] == 40
    assert config["reconstruction"] == [{"name": "splats", "long_side": 64, "settings": {}}]
    assert config["datasets"]["dl3dv"]["poses"] == "layout"


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"budgest": [5]}, ["top level", "'budgest' was unexpected", "'budgets'"]),
        ({"search": {"kay": 5}}, ["search: ", "'kay' was unexpected", "'kept'"]),
        ({"coverages": [33]}, ["coverages[0]", "33 is not one of [25, 40, 60, 80, 100]"]),
        ({"reconstruction": []}, ["reconstruction", "should be non-empty"]),
        ({"reconstruction": [{"as": "a/b"}]}, ["reconstruction[0].as", "'a/b' does not match"]),
        ({"reconstruction": {"name": "nerf"}}, ["reconstruction.name", "one of ['splats'"]),
        ({"reconstruction": {"name": "splat"}}, ["reconstruction.name", "mean 'splats'?"]),
    ],
)
def test_a_wrong_value_is_refused_by_name(changes, parts):
    with pytest.raises(Refusal) as refused:
        complete(copy.deepcopy(SMOKE | changes), SCHEMA, "see the page")
    for part in ["config: ", *parts, "\nHint: ", "see the page"]:
        assert part in str(refused.value)


def test_every_key_is_described_and_documented():
    schema = yaml.safe_load((ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text())
    documented = (ROOT / "config" / "README.md").read_text()
    seen = set()

    def walk(node: dict, path: str) -> None:
        for key, value in node.get("properties", {}).items():
            where = f"{path}{key}"
            seen.add(where)
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
    rows = set(re.findall(r"^\| `([^`]*)` \|", documented.partition("## Every key")[2], re.M))
    assert rows == seen
