"""The command and the Python calls need no package beyond the core dependencies of pyproject."""

import re
import tomllib
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import pytest
from own_python import printed
from packaging.requirements import Requirement
from small_captures import write_ring

PYPROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
# refuses every package that is installed here for the workflow or the tests alone
REFUSING = """
import sys

class Refusing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in REFUSED:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Refusing())
"""
# as on Windows, which lacks some modules and functions
COMMANDS = """
import os, signal

for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None  # an import of it fails
del os.sched_getaffinity, signal.pthread_sigmask

from pathlib import Path
from fsel.cli import main
from fsel.cli.console import Console
from fsel.captures.poses.kept import locked

assert main("select ring -k 3 --patience 0 -o first --quiet".split()) == 0
slow = {"matplotlib", "numba", "pandas", "scipy", "torch"} & set(sys.modules)
assert not slow, f"{slow} take longer to import than the command"
Console.silent = False  # bars are shown at terminals alone, and need tqdm
for line in [
    "select ring -k 6 -o chosen --targets every:8 --patience 0",
    "select ring -k 5 --patience 1s --link -o tried",
    "select ring -k auto -o few --vram 8GB --trainer gsplat --patience 0",
    "info ring --json",
    "compare ring -k 4 --methods fsel,nearest,dpp --steps 3 --long-side 48 -o compared",
    "reconstruct ring --frames chosen/frames.txt --reconstructor splats -o ring.ply",
]:
    assert main(line.split()) == 0, line
assert Path("ring.ply").stat().st_size and Path("compared/compare.txt").is_file()
with locked(Path("lock")):  # what finding poses adds to these
    pass
print(*{name.partition(".")[0] for name in sys.modules})
"""
CALLS = """
import fsel

capture = fsel.read_capture("ring", long_side=48)
for method in fsel.METHODS:
    k = 21 if method == "all" else 4
    chosen = fsel.select(capture, k, targets="every:8", method=method)
    assert len(chosen.indices) == k, method
model = fsel.fit(capture, chosen.indices)
assert fsel.evaluate(capture, model, range(0, len(capture), 8))["psnr"].min() > 0
try:
    capture.save("saved")
except ImportError as error:
    assert "pyarrow is not installed. Hint: pip install 'fsel[workflow]'" in str(error)
else:
    raise AssertionError("it was saved without the packages for tables")
"""


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def core():
    """Names of the distributions that `pip install .` brings, where they are installed."""
    needed = tomllib.loads(PYPROJECT.read_text())["project"]["dependencies"]
    found, open_ = set(), [Requirement(line) for line in needed]
    while open_:
        wanted = open_.pop()
        name = canonical(wanted.name)
        if name in found or (wanted.marker and not wanted.marker.evaluate({"extra": ""})):
            continue
        found.add(name)
        try:
            open_ += [Requirement(line) for line in requires(name) or []]
        except PackageNotFoundError:
            continue
    return found


@pytest.fixture
def program(tmp_path):
    """Run a program beside a capture, every package being refused but the core."""
    write_ring(tmp_path / "ring", frames=24)
    kept = core() | {"fsel", "pip", "setuptools"}
    refused = {
        module
        for module, homes in packages_distributions().items()
        if not kept & {canonical(home) for home in homes}
    }
    assert {"pandas", "pyarrow", "torch", "snakemake", "matplotlib", "skimage"} <= refused

    return lambda code: printed(f"REFUSED = {refused!r}\n{REFUSING}\n{code}", folder=tmp_path)


def test_commands_need_all_of_the_core_and_no_more_nor_do_calls(program):
    imported = program(f"{COMMANDS}\n{CALLS}").splitlines()[-1].split()
    homes = packages_distributions()
    used = {canonical(home) for module in imported for home in homes.get(module, [])}
    needed = tomllib.loads(PYPROJECT.read_text())["project"]["dependencies"]
    assert {canonical(Requirement(line).name) for line in needed} <= used
