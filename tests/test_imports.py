"""Imports run one way, without circles."""

import ast
import re
from pathlib import Path

import fsel

SOURCE = Path(fsel.__file__).parent
PAGE = SOURCE.parents[1] / "docs" / "architecture.md"
ENTRANCES = {"__init__", "__main__"}  # of the package: they may import anything
MODULES = {
    ".".join(("fsel", *path.relative_to(SOURCE).with_suffix("").parts)): path
    for path in SOURCE.rglob("*.py")
}


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
