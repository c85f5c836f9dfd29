"""What a script depends on: each way to refer, on small packages; and on the library itself."""

import ast
import json
import re
from pathlib import Path
from textwrap import dedent

import pytest
from dry_runs import ROOT

from fsel.workflow import dependencies as subject
from fsel.workflow.dependencies import Library, dependencies

LIBRARY = ROOT / "src" / "fsel"
SCRIPTS = ROOT / "workflow" / "scripts"


def written(folder: Path, sources: dict[str, str]) -> Path:
    """A package `toy` of some sources; `shapes`, which names nothing, is always there."""
    for name, text in {"__init__": "", "shapes": "def area(): ...\n", **sources}.items():
        path = folder / "toy" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text))
    return folder / "toy"


def needed(
    folder: Path, script: str, sources: dict[str, str], using: dict | None = None
) -> set[str]:
    """Files that a script needs of a package; sources by their path without an ending."""
    package = written(folder, sources)
    path = folder / "script.py"
    path.write_text(dedent(script))
    return set(Library(package, using or {}).needed(path))


def with_kinds(text: str) -> dict[str, str]:
    """A package `kinds` of two modules, of which `cube` needs `shapes`."""
    cube = "from toy.shapes import area\nclass Cube:\n    size = area()\n"
    return {"kinds/__init__": text, "kinds/cube": cube, "kinds/ball": "class Ball: ...\n"}


def test_only_the_named_symbols_imports_are_followed(tmp_path):
    sources = {
        "main": "from toy import one, two\ndef first(): one.run()\ndef second(): two.run()\n",
        "one": "from toy.shapes import area\nLIMIT = 3\ndef run(): return LIMIT\n",
        "two": "def run(): ...\n",
    }
    found = needed(tmp_path, "from toy.main import first\nfirst()", sources)
    assert found == {"main.py", "one.py"}


def test_functions_classes_constants_and_decorators_are_followed(tmp_path):
    main = """
        from toy import a, b, c, d, e, f
        SIZE = a.x
        class Base(b.x):
            def method(self, start=c.x) -> d.x:
                return SIZE
        @e.x
        def first(): return Base()
        def other(): return f.x
    """
    sources = dict.fromkeys("abcdef", "x = 1\n") | {"main": main}
    found = needed(tmp_path, "from toy.main import first\nfirst()", sources)
    assert found == {"main.py", "a.py", "b.py", "c.py", "d.py", "e.py"}


def test_a_reexport_is_followed_to_the_module_that_defines_it(tmp_path):
    text = "from toy.kinds.ball import Ball\nfrom toy.kinds.cube import Cube\n"
    found = needed(tmp_path, "from toy.kinds import Ball\nBall()", with_kinds(text))
    assert found == {"kinds/__init__.py", "kinds/ball.py"}


KIND = "from toy.kinds import Kind\nKind"
KINDS = "from toy.kinds import KINDS\nKINDS"
HOME, BALL, CUBE = "kinds/__init__.py", "kinds/ball.py", "kinds/cube.py"
REGISTRIES = {
    "objects": "{'cube': Cube, 'ball': Ball}",
    "strings": "{'cube': 'toy.kinds.cube:Cube', 'ball': 'toy.kinds.ball:Ball'}",
    "called": "dict({'cube': 'toy.kinds.cube:Cube', 'ball': 'toy.kinds.ball:Ball'})",
}


@pytest.mark.parametrize("kind", REGISTRIES)
def test_a_registry_is_followed_where_it_is_named_and_as_far_as_it_is_in_use(tmp_path, kind):
    sources = with_kinds(f"""
        from typing import Protocol
        from toy.kinds.ball import Ball
        from toy.kinds.cube import Cube
        class Kind(Protocol): ...
        KINDS: dict = {REGISTRIES[kind]}
    """)
    assert needed(tmp_path, KIND, sources) == {HOME}
    assert needed(tmp_path, KINDS, sources) == {HOME, BALL, CUBE, "shapes.py"}
    assert needed(tmp_path, KINDS, sources, {"toy.kinds:KINDS": ["ball"]}) == {HOME, BALL}


def test_what_is_entered_later_belongs_to_the_registry(tmp_path):
    sources = with_kinds("""
        from toy.kinds import ball
        from toy.kinds.cube import Cube
        class Kind: ...
        KINDS = {}
        for module in (ball,):
            KINDS[module.__name__] = module
        KINDS.update(cube=Cube)
    """)
    assert needed(tmp_path, KIND, sources) == {HOME}
    assert needed(tmp_path, KINDS, sources) == {HOME, BALL, CUBE, "shapes.py"}


def test_imports_in_functions_count_and_those_for_type_checkers_do_not(tmp_path):
    main = """
        import typing
        from typing import TYPE_CHECKING
        if TYPE_CHECKING:
            from toy.checked import Checked
        else:
            from toy.other import Checked
        def first(x: Checked):
            from toy.lazy import run as start
            if typing.TYPE_CHECKING:
                from toy.checked import Checked
            return start()
    """
    sources = dict.fromkeys(["checked", "other"], "class Checked: ...\n")
    sources |= {"main": main, "lazy": "def run(): ...\n"}
    found = needed(tmp_path, "from toy.main import first\nfirst()", sources)
    assert found == {"main.py", "lazy.py", "other.py"}


PROCESS = """
from toy.shapes import area
if __name__ == '__main__':
    area()
def run(): {}
"""


def test_strings_name_symbols_modules_and_the_modules_of_a_package(tmp_path):
    process = {"process": PROCESS.format("...")}
    assert needed(tmp_path, "y = 'toy.process:run'", process) == {"process.py"}
    started = "import subprocess\nsubprocess.run(['python', '-m', 'toy.process'])"
    assert needed(tmp_path, started, process) == {"process.py", "shapes.py"}
    inside = needed(tmp_path, "def f(name): return f'toy.kinds.{name}'", with_kinds(""))
    assert inside == {BALL, CUBE, "shapes.py"}
    others = "y = ['toy', 'see toy.process', 'toy.json', 'toys.process']"
    assert needed(tmp_path, others, process) == set()


def test_a_module_that_starts_itself_needs_what_it_then_runs(tmp_path):
    script = "from toy.process import run\nrun()"
    started = needed(tmp_path, script, {"process": PROCESS.format("__spec__.name")})
    assert started == {"process.py", "shapes.py"}
    assert needed(tmp_path, script, {"process": PROCESS.format("...")}) == {"process.py"}


def test_cycles_end(tmp_path):
    sources = {
        "a": "from toy import b\ndef first(): return b.second()\n",
        "b": "from toy.a import first\ndef second(): return first()\n",
    }
    assert needed(tmp_path, "from toy.a import first\nfirst()", sources) == {"a.py", "b.py"}


def test_attributes_of_modules_are_followed_alone_and_modules_as_values_whole(tmp_path):
    tools = "from toy import a, b\ndef first(): a.x\ndef second(): b.x\n"
    sources = {"tools": tools, "a": "x = 1\n", "b": "x = 1\n"}
    for script in (
        "from toy import tools\ntools.first()",
        "import toy.tools\ntoy.tools.first()",
        "import toy.tools as t\nt.first.__name__",
    ):
        assert needed(tmp_path, script, sources) == {"tools.py", "a.py"}, script
    for script in ("from toy import tools\nprint(tools)", "import toy.tools as t\nvars(t)"):
        assert needed(tmp_path, script, sources) == {"tools.py", "a.py", "b.py"}, script
    assert needed(tmp_path, "from toy import tools\ntools.__file__", sources) == {"tools.py"}


def test_what_a_module_runs_when_imported_is_followed_with_any_symbol(tmp_path):
    main = "from toy.log import start\nfrom toy.shapes import area\nstart()\ndef f(): ...\n"
    sources = {"main": main, "log": "def start(): ...\n"}
    assert needed(tmp_path, "from toy.main import f\nf()", sources) == {"main.py", "log.py"}


def test_names_that_a_function_binds_hide_imports_in_its_body_alone(tmp_path):
    main = """
        from toy import a, b, c, d, e
        def f(a): return a.missing
        def g():
            b = open('x')
            return [b.missing, [c.missing for c in b]]
        def h(d=d.x): return lambda: d.missing
        def i():
            global e
            e = e.x
    """
    sources = dict.fromkeys("abcde", "x = 1\n") | {"main": main}
    script = "from toy.main import f, g, h, i\nf(), g(), h(), i()"
    assert needed(tmp_path, script, sources) == {"main.py", "d.py", "e.py"}


def test_relative_imports_and_lazy_attributes_of_packages(tmp_path):
    sources = {
        "__init__": "HOMES = {'late': 'toy.later'}\ndef __getattr__(name): return HOMES[name]\n",
        "later": "",
        "inner/__init__": "from ..shapes import area\nfrom .own import x\ndef run(): area(), x\n",
        "inner/own": "x = 1\n",
    }
    late = {"__init__.py", "later.py"}
    assert needed(tmp_path, "import toy\ntoy.late()", sources) == late
    inner = {"inner/__init__.py", "inner/own.py", "shapes.py"}
    assert needed(tmp_path, "from toy import inner\ninner.run()", sources) == inner


def test_data_files_are_needed_where_a_followed_symbol_names_them(tmp_path):
    sources = {"store": "STYLE = 'page.css'\ndef style(): STYLE\ndef other(): ...\n"}
    (written(tmp_path, {"data/x": ""}) / "data" / "page.css").write_text("")
    styled = needed(tmp_path, "from toy.store import style\nstyle()", sources)
    assert styled == {"store.py", "data/page.css"}
    assert needed(tmp_path, "from toy.store import other\nother()", sources) == {"store.py"}


FAULTS = {
    "from toy.shapes import volume\nvolume()": r"script\.py: toy\.shapes does not define 'volume'",
    "from toy.nowhere import run\nrun()": r"script\.py: there is no module toy\.nowhere",
    "from toy import shapes\nshapes.volume()": r"toy\.shapes does not define 'volume'",
    "x = 'toy.shapes:volume'": r"toy\.shapes does not define 'volume'",
    "x = 'toy.nowhere:run'": r"there is no module toy\.nowhere",
}


@pytest.mark.parametrize("script", FAULTS)
def test_what_is_not_there_is_refused_by_name(tmp_path, script):
    with pytest.raises(ValueError, match=FAULTS[script]):
        needed(tmp_path, script, {})


def test_a_registry_in_use_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"toy\.shapes does not define 'SHAPES'"):
        needed(tmp_path, "", {}, {"toy.shapes:SHAPES": ["cube"]})


def test_the_answer_is_kept_until_a_file_changes(tmp_path, monkeypatch):
    package = written(tmp_path, {"main": "def run(): ...\n"})
    scripts, store = tmp_path / "scripts", tmp_path / "made" / "store.json"
    scripts.mkdir()
    (scripts / "one.py").write_text("from toy.main import run\nrun()\n")
    asked = (package, scripts, store, {})
    assert dependencies(*asked) == {"one": ["main.py"]}
    with monkeypatch.context() as patched:
        patched.setattr(subject, "Library", None)  # whoever computes, fails
        assert dependencies(*asked) == {"one": ["main.py"]}
    (package / "main.py").write_text("from toy.shapes import area\ndef run(): area()\n")
    assert dependencies(*asked) == {"one": ["main.py", "shapes.py"]}
    (scripts / "two.py").write_text("from toy.shapes import area\narea()\n")
    assert dependencies(*asked)["two"] == ["shapes.py"]
    store.write_text("{")
    assert set(dependencies(*asked)) == {"one", "two"}
    assert json.loads(store.read_text())["files"]["two"] == ["shapes.py"]
    assert [path.name for path in store.parent.iterdir()] == ["store.json"]


@pytest.fixture(scope="module")
def files() -> dict[str, set[str]]:
    """Script -> files of the library that it needs."""
    library = Library(LIBRARY, {})
    return {path.stem: set(library.needed(path)) for path in SCRIPTS.glob("*.py")}


def reachable() -> dict[str, set[str]]:
    """Script -> modules of the library that its imports reach, whole modules at a time."""
    modules, named = {}, {}
    for path in LIBRARY.rglob("*.py"):
        parts = path.relative_to(LIBRARY.parent).with_suffix("").parts
        modules[".".join(parts).removesuffix(".__init__")] = path
    for name, path in modules.items() | {(p.stem, p) for p in SCRIPTS.glob("*.py")}:
        text = path.read_text()
        found = re.findall(r"\bfsel(?:\.\w+)+", text)
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module:
                found += [f"{node.module}.{alias.name}" for alias in node.names]
        parents = [full.rpartition(".")[0] for full in found]
        named[name] = {full for full in (*found, *parents) if full in modules}
    reached = {}
    for script in SCRIPTS.glob("*.py"):
        asked, seen = {script.stem}, set()
        while asked:
            seen |= asked
            asked = set().union(*(named[name] for name in asked)) - seen
        reached[script.stem] = {
            modules[name].relative_to(LIBRARY).as_posix() for name in seen & modules.keys()
        }
    return reached


def test_no_script_needs_what_its_imports_cannot_reach(files):
    for script, reached in reachable().items():
        assert {path for path in files[script] if path.endswith(".py")} <= reached, script


def test_scripts_of_the_workflow_need_what_they_run_and_not_what_lies_beside_it(files):
    assert {"geometry.py", "metrics/fused.py", "reconstruct/__init__.py"} <= files["evaluate"]
    assert {"baselines/fvs.py", "features/conditioned.py", "split.py"} <= files["select"]
    assert not {"baselines/fvs.py", "selector/greedy.py"} & files["evaluate"]
    assert not {"metrics/fused.py", "stages/select.py"} & files["features"]
    assert "report/latex.py" in files["ksweep"]
    assert "layouts/co3d.py" in files["ingest"]


def test_a_reconstructor_that_is_not_in_use_is_not_needed():
    script, home = SCRIPTS / "evaluate.py", "reconstruct/gaussians/"
    both = Library(LIBRARY, {}).needed(script)
    assert any(path.startswith(home) for path in both)
    one = Library(LIBRARY, {"fsel.reconstruct:RECONSTRUCTORS": ["splats"]}).needed(script)
    assert "reconstruct/splats/reconstructor.py" in one
    assert not any(path.startswith(home) for path in one)
