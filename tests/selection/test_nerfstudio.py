"""The data parser for nerfstudio: by stand-ins, and by nerfstudio where it is installed."""

import importlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import pytest
from small_captures import write_ring

import fsel
from fsel.cli import main

NERFSTUDIO = os.environ.get("FSEL_NERFSTUDIO", "")
ASKED = """
import json
import tyro
from nerfstudio.configs.dataparser_configs import AnnotatedDataParserUnion

parser = tyro.cli(AnnotatedDataParserUnion).setup()
found = {part: parser.get_dataparser_outputs(part) for part in ("train", "val", "test")}
names = {part: [file.name for file in one.image_filenames] for part, one in found.items()}
print(json.dumps([names, len(found["train"].metadata["points3D_xyz"])]))
"""
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


@pytest.mark.skipif(not NERFSTUDIO, reason="FSEL_NERFSTUDIO names no environment with nerfstudio")
def test_nerfstudio_s_own_configuration_takes_it(ring, tmp_path):
    paths = (str(Path(fsel.__file__).parent.parent), os.environ.get("PYTHONPATH", ""))
    known = {
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "NERFSTUDIO_DATAPARSER_CONFIGS": "fsel-data=fsel.selection.nerfstudio:SPECIFICATION",
    }
    line = ["fsel-data", "--data", ring, "--k", "6"]
    told = subprocess.run(
        [Path(NERFSTUDIO) / "bin" / "python", "-W", "ignore", "-c", ASKED, *line],
        capture_output=True,
        text=True,
        env=os.environ | known,
        cwd=tmp_path,
    )
    assert told.returncode == 0, told.stderr
    names, points = json.loads(told.stdout.splitlines()[-1])
    assert len(names["train"]) == 6
    assert names["val"] == names["test"] == HELD_OUT
    assert not set(names["train"]) & set(HELD_OUT)
    assert points > 0
