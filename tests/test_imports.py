"""Imports run one way, without circles; and what selecting must not import."""

import ast
import re
import subprocess
import sys
from pathlib import Path

from small_captures import write_ring

import fsel

SOURCE = Path(fsel.__file__).parent
PAGE = SOURCE.parents[1] / "docs" / "architecture.md"
ENTRANCES = {"__init__", "__main__"}  # of the package: they may import anything
MODULES = {
    ".".join(("fsel", *path.relative_to(SOURCE).with_suffix("").parts)): path
    for path in SOURCE.rglob("*.py")
}
PROGRAM = """
import sys
import fsel
from fsel.selectors.greedy import greedy
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import Network
from fsel.experiments.studies.hard_cases.worlds import random_weights, world

problem = world()
fsel.select(problem.capture, 6, patience=0)
fsel.select(problem.capture, 6, method="untrained")
greedy(POLICIES["less_is_more"].prepare(problem), Network(random_weights(0)), 6)
print(*{"torch", "cma", "snakemake", "matplotlib"} & set(sys.modules))
"""
COMMAND = """
import sys
from fsel.cli import main

code = main(["select", sys.argv[1], "-k", "3", "--patience", "0", "-o", sys.argv[2], "--quiet"])
slow = {"matplotlib", "numba", "pandas", "scipy", "torch"}
print(code, *slow & set(sys.modules))
"""


def home(name):
    """The module that a dotted name lies in, if it is one of the library's."""
    for found in (name, f"{name}.__init__"):
        if found in MODULES:
            return found
    return home(name.rpartition(".")[0]) if "." in name else None


def imports(module):
    """Modules that one imports, anywhere in it; those for type checkers too."""
    found = set()
    for node in ast.walk(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.Import):
            found |= {home(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {home(f"{node.module}.{alias.name}") for alias in node.names}
        elif isinstance(node, ast.Constant) and re.fullmatch(r"fsel\.[\w.]+:\w+", str(node.value)):
            found.add(home(node.value.partition(":")[0]))  # an entry of a registry
    return found - {None, module}


def room(module):
    return module.split(".")[1]


def floors():
    rows = re.findall(r"^\| (\d+) \| `(\w+)` \|", PAGE.read_text(), re.M)
    return {name: int(number) for number, name in rows}


def test_the_map_names_every_room():
    assert set(floors()) == {room(module) for module in MODULES} - ENTRANCES


def test_imports_run_down_the_map():
    floor = floors()
    upward = [
        f"{module} imports {target}"
        for module in MODULES
        if room(module) not in ENTRANCES
        for target in imports(module)
        if room(target) != room(module)
        and (room(target) in ENTRANCES or floor[room(target)] >= floor[room(module)])
    ]
    assert upward == []


def test_no_module_imports_itself_by_way_of_others():
    reach = {module: imports(module) for module in MODULES}
    open_ = dict(reach)
    while leaves := [module for module, found in open_.items() if not found & open_.keys()]:
        for module in leaves:
            del open_[module]
    assert sorted(open_) == []


def test_neither_torch_nor_what_only_experiments_need():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []


def test_the_command_imports_nothing_that_takes_longer_than_it(tmp_path):
    write_ring(tmp_path / "capture", frames=9, cloud=30)
    paths = [str(tmp_path / name) for name in ("capture", "out")]
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *paths], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["0"]
