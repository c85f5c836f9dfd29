"""Docstrings are sentences: they begin with a noun or a verb."""

import ast
import re
from pathlib import Path

import fsel

SOURCES = Path(fsel.__file__).parent
FRAGMENT = re.compile(
    r"(about|after|against|along|among|and|as|at|before|below|beside|between|but|by|during|for|from"
    r"|how|if|in|into|less|like|of|on|or|over|since|so|than|that|through|to|towards|under|until"
    r"|what|when|where|whether|which|while|who|why|with|within|without)\b",
    re.IGNORECASE,
)
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def fragments(path):
    """`file:line: first line` of docstrings that begin with a preposition or a small letter."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        text = ast.get_docstring(node) if isinstance(node, DOCUMENTED) else None
        if text and (text[0].islower() or FRAGMENT.match(text)):
            yield f"{path.relative_to(SOURCES)}:{node.body[0].lineno}: {text.splitlines()[0]}"


def test_fragments_are_recognised(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "SOURCES", tmp_path)
    path = tmp_path / "module.py"
    path.write_text(
        '"""Of all."""\ndef a():\n    """z-scores of all."""\ndef b():\n    """Sum them."""\n'
    )
    assert list(fragments(path)) == ["module.py:1: Of all.", "module.py:3: z-scores of all."]


def test_docstrings_begin_with_a_noun_or_a_verb():
    wrong = [line for path in sorted(SOURCES.rglob("*.py")) for line in fragments(path)]
    assert not wrong, "\n".join(["not a noun or a verb first:", *wrong])
