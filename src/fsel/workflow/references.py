"""What one source binds at its top level, and what a piece of it refers to; nothing is imported."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.util import resolve_name
from pathlib import Path

EFFECTS, MAIN = "", "__main__"
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
SCOPES = (*FUNCTIONS, *COMPREHENSIONS, ast.ClassDef)
IMPORTS = (ast.Import, ast.ImportFrom)

Use = list[str] | str | ast.Import | ast.ImportFrom


@dataclass
class Source:
    """What the top level of a module binds.

    Attributes:
        package: that relative imports start from.
        statements: name -> what defines or changes it; under `EFFECTS` what binds nothing, under
            `MAIN` what runs when the module is started as a process.
        imports: name -> module, or module and name in it.
    """

    package: str
    statements: dict[str, list[ast.AST]] = field(default_factory=dict)
    imports: dict[str, list[str]] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path, package: str) -> Source:
        source = cls(package)
        for node in ast.parse(path.read_text(encoding="utf-8"), str(path)).body:
            source._bind(node)
        return source

    def _bind(self, node: ast.stmt) -> None:
        names, changed = set(), set()
        for part in inside(node, SCOPES):
            if isinstance(part, IMPORTS):
                self.imports |= imported(part, self.package)
            elif isinstance(part, DEFINITIONS):
                names.add(part.name)
            elif isinstance(part, ast.Expr):
                changed.add(_root(part.value))  # REGISTRY.update(...) belongs to REGISTRY
            elif isinstance(part, (ast.Attribute, ast.Subscript)) and _stored(part):
                changed.add(_root(part))
            elif isinstance(part, ast.Name) and _stored(part):
                names.add(part.id)
        if isinstance(node, ast.If) and _root(getattr(node.test, "left", None)) == "__name__":
            names, changed = {MAIN}, set()
        for bound in names | (changed & set(self.statements)) or {EFFECTS}:
            self.statements.setdefault(bound, []).append(node)


def imported(node: ast.Import | ast.ImportFrom, package: str) -> dict[str, list[str]]:
    """Name that an import binds -> module, or module and name in it."""
    if isinstance(node, ast.Import):
        names = [(a.asname or a.name.split(".")[0], a) for a in node.names]
        return {bound: [a.name if a.asname else bound] for bound, a in names}
    module = resolve_name("." * node.level + (node.module or ""), package)
    return {a.asname or a.name: [module, a.name] for a in node.names}


def inside(node: ast.AST, closed: tuple[type, ...] = ()) -> Iterator[ast.AST]:
    """A node and those below; not what is for type checkers alone, nor what is in closed nodes."""
    asked = [node]
    while asked:
        node = asked.pop()
        yield node
        if _checks_types(node):
            asked += node.orelse
        elif not isinstance(node, closed):
            asked += ast.iter_child_nodes(node)


def references(node: ast.AST) -> list[Use]:
    """Names of outer scopes with the attributes taken of them, strings, and imports."""
    found: list[Use] = []
    _collect(node, frozenset(), found)
    return found


def _collect(node: ast.AST, hidden: frozenset[str], found: list[Use]) -> None:
    """Append the references of a node and those below, but names that a scope around it binds."""
    chain: list[str] = []
    while isinstance(node, ast.Attribute):
        chain.insert(0, node.attr)
        node = node.value
    if isinstance(node, ast.Name) and node.id not in hidden:
        found.append([node.id, *chain])
    elif isinstance(node, IMPORTS):
        found.append(node)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        found.append(node.value)
    own, outer = _scope(node)
    for child in node.orelse if _checks_types(node) else ast.iter_child_nodes(node):
        _collect(child, hidden if child in outer else hidden | own, found)


def _scope(node: ast.AST) -> tuple[set[str], list[ast.AST]]:
    """Names that a node binds for those below it, imports aside, and which of them see outside."""
    if isinstance(node, COMPREHENSIONS):
        parts = [part for each in node.generators for part in ast.walk(each.target)]
        return {part.id for part in parts if isinstance(part, ast.Name)}, []
    if not isinstance(node, FUNCTIONS):
        return set(), []
    body = node.body if isinstance(node.body, list) else [node.body]
    parts = [part for each in body for part in inside(each, SCOPES)]
    names = {part.arg for part in ast.walk(node.args) if isinstance(part, ast.arg)}
    names |= {part.name for part in parts if isinstance(part, DEFINITIONS)}
    names |= {part.id for part in parts if isinstance(part, ast.Name) and _stored(part)}
    elsewhere = {name for part in parts if isinstance(part, ast.Global) for name in part.names}
    return names - elsewhere, [each for each in ast.iter_child_nodes(node) if each not in body]


def limited(node: ast.AST, keys: list[str] | None) -> ast.AST:
    """The statement of a registry, `NAME = {...}` or `NAME = Class(..., {...})`, with some keys."""
    value = getattr(node, "value", None)
    parts = [value.func, *value.args] if isinstance(value, ast.Call) else [value]
    if keys is None or not any(isinstance(part, ast.Dict) for part in parts):
        return node
    kept: list[ast.AST] = []
    for part in parts:
        if isinstance(part, ast.Dict):
            pairs = zip(part.keys, part.values, strict=True)
            kept += [v for k, v in pairs if not isinstance(k, ast.Constant) or k.value in keys]
        else:
            kept.append(part)
    return ast.Tuple(kept)


def _root(node: ast.AST | None) -> str:
    """`a` of `a.b[c].d(e)`."""
    while isinstance(node, (ast.Attribute, ast.Subscript, ast.Call, ast.Starred)):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.id if isinstance(node, ast.Name) else ""


def _checks_types(node: ast.AST) -> bool:
    test = getattr(node, "test", None)
    name = test.attr if isinstance(test, ast.Attribute) else getattr(test, "id", "")
    return isinstance(node, ast.If) and name == "TYPE_CHECKING"


def _stored(node: ast.Name | ast.Attribute | ast.Subscript) -> bool:
    return isinstance(node.ctx, ast.Store)
