"""The wheel and the source distribution hold all that the installed package needs."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "fsel"
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
DATA = {".json", ".safetensors", ".css", ".js", ".typed"}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Both distributions; the wheel is built from the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_distributions_hold_every_module_and_every_data_file(built):
    names = sorted(path.name for path in built.iterdir())
    assert names == [f"fsel-{VERSION}-py3-none-any.whl", f"fsel-{VERSION}.tar.gz"]
    with zipfile.ZipFile(built / names[0]) as wheel:
        packed = set(wheel.namelist())
        entry_points = wheel.read(f"fsel-{VERSION}.dist-info/entry_points.txt").decode()
    assert "fsel = fsel.cli:main" in entry_points
    wanted = {
        path.relative_to(PACKAGE.parent).as_posix()
        for path in PACKAGE.rglob("*")
        if path.suffix in DATA | {".py"}
    }
    assert wanted - packed == set()
    with tarfile.open(built / names[1]) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    assert {"README.md", "LICENSE", "pyproject.toml", "src/fsel/__init__.py"} <= packed
    assert "src/fsel/pages/viewer/web/viewer.js" in packed


def installed(distribution, place):
    """Install into a new environment, and return what runs its `fsel`."""
    # the other packages are those of this one: of a folder in PYTHONPATH, Python does not follow
    # the `.pth` files, by which the checkout is installed
    own = os.environ | {"PYTHONPATH": sysconfig.get_path("purelib")}
    own |= {"FSEL_CACHE": str(place / "cache")}
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", place], check=True)
    pip = [sys.executable, "-m", "pip", "--python", place / "bin" / "python", "install", "--quiet"]
    words = ["--no-deps", "--no-index", "--no-build-isolation", distribution]
    subprocess.run([*pip, *words], check=True, env=own)
    run = partial(subprocess.run, cwd=place, env=own, check=True, stdout=subprocess.PIPE, text=True)
    return lambda *arguments: run([place / "bin" / "fsel", *arguments]).stdout


def test_both_distributions_select_alike(built, tmp_path):
    picked = []
    for path in sorted(built.iterdir()):  # the wheel first
        place = tmp_path / path.suffix
        fsel = installed(path, place)
        assert fsel("--version").split() == ["fsel", VERSION]
        if not picked:
            fsel("demo", "garden", "-o", tmp_path / "garden")
            compiled = {path.relative_to(place).parts[:2] for path in place.rglob("*.nb[ic]")}
            assert compiled == {("cache", "compiled")}  # what pip uninstalls leaves nothing behind
        fsel("select", tmp_path / "garden", "-k", "5", "--patience", "0", "-o", "picked")
        picked.append((place / "picked" / "frames.txt").read_text().split())
    assert picked[0] == picked[1]
    assert len(picked[0]) == 5
