"""The data parser for nerfstudio, by stand-ins of nerfstudio's classes."""

import importlib
import json
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import pytest
from small_captures import write_ring

from fsel.cli import main

HELD_OUT = [f"frame_{i:03d}.jpg" for i in (0, 8, 16)]
BASES = "nerfstudio.data.dataparsers"


@dataclass
class StandInConfig:
    """The fields that the plugin reads, and `setup` as nerfstudio has it."""

    data: Path = Path()
    downscale_factor: int | None = None
    load_3D_points: bool = False
    _target: type = field(default=object)

    def setup(self):
        return self._target(self)


@dataclass
class StandIn:
    """A parser that returns the images of a split's list."""

    config: StandInConfig

    def get_dataparser_outputs(self, split):
        return self._generate_dataparser_outputs(split)

    def _generate_dataparser_outputs(self, split):
        listed = json.loads(self.config.data.read_text())[f"{split}_filenames"]
        files = [self.config.data.parent / name for name in listed]
        return type("Outputs", (), {"image_filenames": files})


@pytest.fixture
def plugin(monkeypatch):
    """The module, its bases being stand-ins."""
    names = {
        f"{BASES}.base_dataparser": {"DataparserOutputs": object},
        f"{BASES}.nerfstudio_dataparser": {
            "Nerfstudio": StandIn,
            "NerfstudioDataParserConfig": StandInConfig,
        },
        "nerfstudio.plugins.registry_dataparser": {
            "DataParserSpecification": lambda config, description: config
        },
    }
    for name in ("nerfstudio", "nerfstudio.data", BASES, "nerfstudio.plugins", *names):
        module = ModuleType(name)
        vars(module).update(names.get(name, {}))
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "fsel.selection.nerfstudio", raising=False)
    yield importlib.import_module("fsel.selection.nerfstudio")
    sys.modules.pop("fsel.selection.nerfstudio", None)


@pytest.fixture
def ring(tmp_path, monkeypatch):
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    write_ring(tmp_path / "ring")
    return tmp_path / "ring"


def names(parser, split):
    return [file.name for file in parser.get_dataparser_outputs(split).image_filenames]


def test_picks_train_and_held_out_frames_evaluate(plugin, ring, tmp_path):
    line = ["select", ring, "-k", 6, "--targets", "every:8", "--method", "fsel"]
    assert main([*map(str, line), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    picked = (tmp_path / "out" / "frames.txt").read_text().split()
    parser = plugin.FselConfig(data=ring, k=6).setup()
    assert names(parser, "train") == sorted(picked)
    assert names(parser, "val") == names(parser, "test") == HELD_OUT
    assert parser.config.data == ring  # what nerfstudio writes down is what was asked
    (made,) = (folder for folder in (tmp_path / "cache/nerfstudio").iterdir() if folder.is_dir())
    before = made.stat().st_mtime_ns
    assert names(plugin.FselConfig(data=ring, k=6).setup(), "test") == HELD_OUT
    assert made.stat().st_mtime_ns == before
    assert len(names(plugin.FselConfig(data=ring, k=5).setup(), "train")) == 5


def test_images_reduced_by_other_means_are_refused(plugin, ring):
    with pytest.raises(ValueError, match=r"downscale_factor is 4; .* --long-side"):
        plugin.selection(plugin.FselConfig(data=ring, downscale_factor=4))
