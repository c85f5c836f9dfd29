"""The wheel and the source distribution hold all that the installed package needs."""

import subprocess
import sys
import tarfile
import tomllib
import zipfile
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
