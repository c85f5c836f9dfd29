"""What a module depends on: each way to refer, on small packages; and on the library itself."""

import json
import os
from pathlib import Path
from textwrap import dedent

import pytest
from dry_runs import ROOT

from fsel.reconstruct import RECONSTRUCTORS
from fsel.workflow.dependencies import Library

LIBRARY = ROOT / "src" / "fsel"


def package(folder: Path, **sources: str) -> Path:
    """A package `toy` of some sources; `leaf`, which names nothing, is always there."""
    for name, text in {"__init__": "", "leaf": "def area(): ...\n", **sources}.items():
        path = folder / "toy" / f"{name.replace('__init__', '<>').replace('_', '/')}.py"
        path = Path(str(path).replace("<>", "__init__"))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text))
    return folder / "toy"


def needed(folder: Path, main: str, unused: tuple = (), **sources: str) -> set[str]:
    """Files that a module `toy.main` needs, itself aside."""
    toy = package(folder, main=main, **sources)
    found = Library(toy, folder / "store.json").needed("toy.main", unused)
    return {Path(path).relative_to(toy).as_posix() for path in found} - {"main.py"}


REFERENCES = [
    "import toy.leaf",
    "import toy.leaf as other",
    "from toy import leaf",
    "from toy.leaf import area",
    "from .leaf import area",
    "from . import leaf",
    "def later():\n    from toy.leaf import area",
    "class A:\n    def b(self):\n        import toy.leaf",
    'HOMES = {"a": "toy.leaf:area"}',
    'command = ["-m", "toy.leaf"]',
    "if TYPE_CHECKING:\n    import toy.b\nelse:\n    import toy.leaf",
]
OTHERS = [
    "",
    "import numpy",
    "from tools.leaf import area",
    '"""As toy.leaf does."""',
    'text = "leaf.py"',
    "import typing\nif typing.TYPE_CHECKING:\n    from toy.leaf import area",
    "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import toy.leaf",
]


@pytest.mark.parametrize(
    ("main", "found"),
    [*((main, {"leaf.py"}) for main in REFERENCES), *((main, set()) for main in OTHERS)],
)
def test_what_is_a_reference_to_a_module(main, found, tmp_path):
    assert needed(tmp_path, main, b="") == found


def test_imports_are_followed_through_packages_and_circles(tmp_path):
    found = needed(
        tmp_path,
        "import toy.sub.inner",
        sub___init__="import toy.leaf",
        sub_inner="import toy.other",
        other="import toy.main",
    )
    assert found == {"sub/__init__.py", "sub/inner.py", "leaf.py", "other.py"}


def test_data_files_are_needed_where_they_are_named(tmp_path):
    package(tmp_path)
    (tmp_path / "toy" / "numbers.json").write_text("1")
    assert needed(tmp_path, 'NAME = "numbers.json"') == {"numbers.json"}
    assert needed(tmp_path, 'NAME = "others.json"') == set()


def test_entries_of_a_registry_that_are_not_used_are_left_out(tmp_path):
    main = 'HOMES = {"a": "toy.leaf:area", "b": "toy.b:B"}'
    assert needed(tmp_path, main, b="") == {"leaf.py", "b.py"}
    assert needed(tmp_path, main, ("toy.b:B",), b="") == {"leaf.py"}


def test_modules_aside_are_left_out(tmp_path):
    toy = package(tmp_path, main="import toy.kept, toy.aside.x", kept="", aside_x="import toy.leaf")
    found = Library(toy, tmp_path / "store.json", aside="toy.aside").needed("toy.main")
    assert [Path(path).name for path in found] == ["kept.py", "main.py"]


def test_a_source_that_has_changed_is_read_again_and_no_other(tmp_path):
    toy, store = package(tmp_path, main="import toy.leaf", b=""), tmp_path / "store.json"
    assert len(Library(toy, store).needed("toy.main")) == 2
    kept = json.loads(store.read_text())
    kept["toy.b"]["words"] = ["toy.leaf"]  # seen only if it is not read again
    store.write_text(json.dumps(kept))
    (toy / "main.py").write_text("import toy.b")
    os.utime(toy / "main.py", (1, 1))
    names = [Path(path).name for path in Library(toy, store).needed("toy.main")]
    assert names == ["b.py", "leaf.py", "main.py"]
    store.write_text("{broken")
    assert len(Library(toy, store).needed("toy.main")) == 2


def test_a_digest_changes_with_what_a_module_needs_and_with_nothing_else(tmp_path):
    toy, store = package(tmp_path, main="import toy.leaf", b=""), tmp_path / "store.json"
    first = Library(toy, store).digest("toy.main")
    (toy / "b.py").write_text("more = 1")
    os.utime(toy / "leaf.py")
    assert Library(toy, store).digest("toy.main") == first
    (toy / "leaf.py").write_text("def area(): return 1\n")
    assert Library(toy, store).digest("toy.main") != first


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return Library(LIBRARY, tmp_path_factory.mktemp("store") / "store.json", "fsel.workflow")


@pytest.mark.parametrize(
    ("stage", "part", "without"),
    [
        ("generate", "synthetic/families.py", "selectors/baselines/by_pose.py"),
        ("select", "selectors/baselines/by_pose.py", "evaluation/latex.py"),
        ("evaluate", "evaluation/evaluator.py", "reconstruct/gaussians/__init__.py"),
        ("ksweep", "evaluation/latex.py", "synthetic/families.py"),
    ],
)
def test_stages_depend_on_what_they_use(library, stage, part, without):
    others = [home for name, home in RECONSTRUCTORS.homes.items() if name != "splats"]
    paths = library.needed(f"fsel.stages.{stage}", others)
    found = {Path(path).relative_to(LIBRARY).as_posix() for path in paths}
    assert found >= {f"stages/{stage}.py", part}
    assert without not in found
    assert not any(path.startswith("workflow/") for path in found)
