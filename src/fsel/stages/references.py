"""What one source binds at its top level, and what a piece of it refers to; nothing is imported."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.util import resolve_name

EFFECTS, MAIN = "", "__main__"
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
SCOPES = (*DEFINITIONS, ast.Lambda, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
IMPORTS = (ast.Import, ast.ImportFrom)


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
    def parse(cls, text: str, package: str) -> Source:
        source = cls(package)
        for node in ast.parse(text).body:
            source._bind(node)
        return source

    def _bind(self, node: ast.stmt) -> None:
        names, changed = set(), set()
        for part in inside(node, SCOPES):
            if isinstance(part, IMPORTS):
                self.imports |= imported(part, self.package)
            elif isinstance(part, DEFINITIONS):
                names.add(part.name)
            elif isinstance(getattr(part, "ctx", None), ast.Store):
                (names if isinstance(part, ast.Name) else changed).add(_root(part))
            elif isinstance(part, ast.Expr):
                changed.add(_root(part.value))  # REGISTRY.update(...) belongs to REGISTRY
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
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            asked += node.orelse
        elif not isinstance(node, closed):
            asked += ast.iter_child_nodes(node)


def references(node: ast.AST) -> list[list[str] | str | ast.Import | ast.ImportFrom]:
    """Names of outer scopes with the attributes taken of them, strings, and imports."""
    found: list[list[str] | str | ast.Import | ast.ImportFrom] = []
    _collect(node, frozenset(), found)
    return found


def _collect(node: ast.AST, hidden: frozenset[str], found: list) -> None:
    """Append the references below a node, but names that a function around it binds."""
    children = list(ast.iter_child_nodes(node))
    if isinstance(node, (ast.Attribute, ast.Name)):
        chain: list[str] = []
        while isinstance(node, ast.Attribute):
            chain.insert(0, node.attr)
            node = node.value
        children = [node]
        if isinstance(node, ast.Name):
            children = []
            if node.id not in hidden:
                found.append([node.id, *chain])
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        found.append(node.value)
    elif isinstance(node, IMPORTS):
        found.append(node)
    elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        children = node.orelse
    elif isinstance(node, (*DEFINITIONS[:2], *SCOPES[len(DEFINITIONS) :])):
        hidden |= _local(node)
    for child in children:
        _collect(child, hidden, found)


def _local(node: ast.AST) -> set[str]:
    """Names that a function or a comprehension binds; imports in it aside."""
    if isinstance(node, SCOPES[len(DEFINITIONS) + 1 :]):
        parts = [part for each in node.generators for part in ast.walk(each.target)]
    else:
        body = node.body if isinstance(node.body, list) else [node.body]
        parts = [part for each in (node.args, *body) for part in inside(each, SCOPES)]
    names = {part.arg for part in parts if isinstance(part, ast.arg)}
    names |= {part.name for part in parts if isinstance(part, DEFINITIONS)}
    names |= {p.id for p in parts if isinstance(p, ast.Name) and isinstance(p.ctx, ast.Store)}
    return names - {name for p in parts if isinstance(p, ast.Global) for name in p.names}


def limited(node: ast.AST, keys: list[str] | None) -> ast.AST:
    """The statement of a registry, a dict or made from one, with the entries in use alone."""
    entries = next((part for part in ast.walk(node) if isinstance(part, ast.Dict)), None)
    if keys is None or entries is None:
        return node
    pairs = zip(entries.keys, entries.values, strict=True)
    kept = [v for k, v in pairs if not isinstance(k, ast.Constant) or k.value in keys]
    value = getattr(node, "value", None)
    return ast.Tuple([value.func, *kept] if isinstance(value, ast.Call) else kept)


def _root(node: ast.AST | None) -> str:
    """`a` of `a.b[c].d(e)`."""
    while isinstance(node, (ast.Attribute, ast.Subscript, ast.Call, ast.Starred)):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.id if isinstance(node, ast.Name) else ""
