"""Files of the library that a module needs: what it imports, and what those import.

The sources are read and nothing is imported. What counts: imports anywhere in a module, but for
type checkers alone; strings that name a module, such as `package.module:name` in a registry; and
strings that are the name of a data file of the package.
"""

from __future__ import annotations

import ast
import json
import os
from collections.abc import Collection, Iterable, Iterator
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

from fsel.core.files import digest, fingerprint, write_text


class Library:
    """The sources and data files of one package, but for modules whose names begin with `aside`.

    The JSON file `store` keeps what each source refers to, until the source changes.
    """

    def __init__(self, folder: Path, store: Path, aside: str = "-") -> None:
        self.folder, self.aside = folder, aside
        files = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.parent.name[:2] != "__"]
        self.modules = {self._name(path): path for path in files if path.suffix == ".py"}
        self.data = {path.name: path for path in files if path.suffix not in (".py", ".pyc")}
        self.referred = self._referred(store)
        self._contents: dict[str, str] = {}  # path -> digest of the file

    def digest(self, module: str, unused: Collection[str] = ()) -> str:
        """Return a digest of the contents of the files that a module needs, see `needed`."""
        files = self.needed(module, unused)
        for path in set(files) - set(self._contents):
            self._contents[path] = fingerprint([path], {})
        return digest({os.path.relpath(p, self.folder): self._contents[p] for p in files})

    def needed(self, module: str, unused: Collection[str] = ()) -> list[str]:
        """Return sorted paths of the files that a module needs, its own too, without entries of
        registries, `package.module:name`, that are `unused`."""
        found, data, left = set[str](), set[str](), [module]
        while left:
            name = left.pop()
            if name in found:
                continue
            found.add(name)
            for word in set(self.referred[name]) - set(unused):
                if word in self.data:
                    data.add(word)
                left += [home for home in self._behind(word) if not home.startswith(self.aside)]
        return sorted(map(str, [self.modules[n] for n in found] + [self.data[n] for n in data]))

    def _behind(self, word: str) -> Iterator[str]:
        """Modules that run when a dotted name is imported, the package's own first one aside."""
        parts = word.partition(":")[0].split(".")
        names = (".".join(parts[:n]) for n in range(2, len(parts) + 1))
        return (name for name in names if name in self.modules)

    def _referred(self, store: Path) -> dict[str, list[str]]:
        """Module -> the words in its source that may stand for modules or data files."""
        try:
            known = json.loads(store.read_text(encoding="utf-8"))
        except (FileNotFoundError, ValueError):
            known = {}
        entries: dict[str, dict[str, Any]] = {}
        for name, path in self.modules.items():
            state = [path.stat().st_size, path.stat().st_mtime_ns]
            kept = known.get(name, {})
            words = kept["words"] if kept.get("state") == state else self._words(name, path)
            entries[name] = {"state": state, "words": words}
        if entries != known:
            write_text(json.dumps(entries), store)
        return {name: entry["words"] for name, entry in entries.items()}

    def _words(self, name: str, path: Path) -> list[str]:
        package = name if path.stem == "__init__" else name.rpartition(".")[0]
        tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
        words: set[str] = set()
        for node in _nodes(tree):
            if isinstance(node, ast.Import):
                words |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                home = resolve_name("." * node.level + (node.module or ""), package)
                words |= {f"{home}.{alias.name}" for alias in node.names}
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                words.add(node.value)
        return sorted(word for word in words if word in self.data or self._is_home(word))

    def _is_home(self, word: str) -> bool:
        """Say whether a word is a module, or a name that may be taken of one."""
        home, _, inside = word.replace(":", ".").rpartition(".")
        return word in self.modules or (home in self.modules and inside.isidentifier())

    def _name(self, path: Path) -> str:
        parts = path.relative_to(self.folder.parent).with_suffix("").parts
        return ".".join(parts).removesuffix(".__init__")


def _nodes(node: ast.AST) -> Iterator[ast.AST]:
    """A node and those below, but what is for type checkers alone."""
    yield node
    children: Iterable[ast.AST] = ast.iter_child_nodes(node)
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        children = node.orelse
    for child in children:
        yield from _nodes(child)
