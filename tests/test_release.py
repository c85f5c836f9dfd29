"""The wheel and the source distribution hold all that the installed package needs."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "fsel"
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
DATA = {".json", ".safetensors", ".css", ".js", ".typed"}
PROGRAM = """
import fsel
print(fsel.__file__, *(fsel.METHODS[name].name for name in ("fsel", "less_is_more")), sep="\\n")
"""


def run(*command, **options):
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Both distributions; the wheel is built from the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, cwd=ROOT)
    return folder


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """A virtual environment with the wheel alone; what it depends on is this one's."""
    place = tmp_path_factory.mktemp("environment")
    run(sys.executable, "-m", "venv", "--without-pip", place)
    binaries = place / ("Scripts" if os.name == "nt" else "bin")
    (wheel,) = built.glob("*.whl")
    outside = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    install = ["install", "--quiet", "--no-deps", "--no-index", wheel]
    run(sys.executable, "-m", "pip", "--python", binaries / "python", *install, env=outside)
    return binaries, outside | {"PYTHONPATH": sysconfig.get_path("purelib")}


def test_the_distributions_hold_every_module_and_every_data_file(built):
    names = sorted(path.name for path in built.iterdir())
    assert names == [f"fsel-{VERSION}-py3-none-any.whl", f"fsel-{VERSION}.tar.gz"]
    packed = set(zipfile.ZipFile(built / names[0]).namelist())
    wanted = {
        path.relative_to(PACKAGE.parent).as_posix()
        for path in PACKAGE.rglob("*")
        if path.suffix in DATA | {".py"}
    }
    assert wanted - packed == set()
    with tarfile.open(built / names[1]) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    assert {"README.md", "LICENSE", "pyproject.toml", "src/fsel/__init__.py"} <= packed


def test_the_installed_package_has_its_trained_scorers(installed, tmp_path):
    binaries, environment = installed
    assert run(binaries / "fsel", "--version", env=environment).split() == ["fsel", VERSION]
    printed = run(binaries / "python", "-c", PROGRAM, env=environment, cwd=tmp_path).splitlines()
    assert Path(printed[0]).is_relative_to(binaries.parent)
    assert printed[1:] == ["fsel", "less_is_more"]
