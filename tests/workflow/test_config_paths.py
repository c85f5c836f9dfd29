"""Names of folders in a config that lead out of where they belong, and sizes beyond sense."""

from pathlib import Path

import jsonschema
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = yaml.safe_load((ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text())
SMOKE = yaml.safe_load((ROOT / "config" / "smoke.yaml").read_text())


@pytest.mark.parametrize("name", ["../x", "a/../b", "/etc", ".", ".."])
def test_a_scene_lies_in_its_root(name):
    datasets = {
        "real": {
            "label": "Real",
            "layout": "auto",
            "root": "captures",
            "scenes": {"evaluation": [name]},
        }
    }
    with pytest.raises(jsonschema.ValidationError, match="does not match"):
        jsonschema.validate(SMOKE | {"datasets": datasets}, SCHEMA)
    datasets["real"]["scenes"]["evaluation"] = ["apple/110_1", "..x", "x.y"]
    jsonschema.validate(SMOKE | {"datasets": datasets}, SCHEMA)


@pytest.mark.parametrize("results", ["../../x", "..", "a/../../b"])
def test_results_do_not_lead_upwards(results):
    with pytest.raises(jsonschema.ValidationError, match="does not match"):
        jsonschema.validate(SMOKE | {"pathvars": {"results": results}}, SCHEMA)
    jsonschema.validate(SMOKE | {"pathvars": {"results": "/scratch/a..b"}}, SCHEMA)


def test_images_have_a_largest_size():
    with pytest.raises(jsonschema.ValidationError, match="maximum of 16384"):
        jsonschema.validate(SMOKE | {"long_side": 1e9}, SCHEMA)
