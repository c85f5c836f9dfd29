"""Which files of the library a script needs, found by reading the sources; nothing is imported.

References are followed from symbol to symbol: the names in the script, the names in the functions,
classes and constants that they stand for, and so on. A module with a followed symbol is needed as a
file; its other symbols are not followed. What counts as a reference:

- a name that an import has bound, at the top of a module or in a function; imports for type
  checkers alone do not count;
- an attribute of a module; a module that is used as a value stands for all its symbols;
- the strings "package.module:name", "package.module" (all its symbols) and "package." (all modules
  in it, as in an f-string), and a string that is the name of a data file of the package.

Statements at the top of a module that bind nothing run when it is imported: they are followed with
every symbol of it. Attributes of objects are not followed, their class is.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from fsel.utils.files import write_text
from fsel.workflow.references import EFFECTS, IMPORTS, MAIN, Source, imported, limited, references

ALL = "*"

Symbol = tuple[str, str]  # module, name in it


def dependencies(
    folder: Path, scripts: Path, store: Path, using: Mapping[str, Iterable[str]]
) -> dict[str, list[str]]:
    """Files of a package that each script needs; computed anew when any file has changed.

    Args:
        folder: of the package.
        scripts: folder of the scripts.
        store: JSON file for the answer, which every job of a workflow asks for.
        using: "package.module:NAME" of a registry -> its keys in use; others are not followed.

    Returns:
        Name of the script without its ending -> sorted paths relative to `folder`.

    Raises:
        ValueError: for a reference to what is not there.
    """
    limits = {name: sorted(keys) for name, keys in using.items()}
    state = _state((folder, scripts), limits)
    try:
        known = json.loads(store.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        known = {}
    if known.get("state") != state:
        library = Library(folder, limits)
        found = {path.stem: library.needed(path) for path in sorted(scripts.glob("*.py"))}
        known = {"state": state, "files": found}
        write_text(json.dumps(known), store)
    return known["files"]


class Library:
    """The sources and data files of one package."""

    def __init__(self, folder: Path, using: Mapping[str, list[str]]):
        self.folder, self.using = folder, using
        self.paths: dict[str, Path] = {"": folder}
        self.data: dict[str, list[Path]] = {}
        self.sources: dict[str, Source] = {}
        self.followed: dict[Symbol, list[Symbol | Path]] = {}
        for path in map(Path, _files((folder,))):
            if path.suffix == ".py":
                parts = path.relative_to(folder.parent).with_suffix("").parts
                self.paths[".".join(parts).removesuffix(".__init__")] = path
            else:
                self.data.setdefault(path.name, []).append(path)
        for registry in using:
            list(self._resolved("", registry.split(":")))
        self.spelled = re.compile(rf"({re.escape(folder.name)}(?:\.\w+)+)(?::(\w+)|(\.)|)")

    def needed(self, script: Path) -> list[str]:
        """Sorted paths of the files that a script needs, relative to the package's folder."""
        self.paths[str(script)] = script
        asked: list[Symbol | Path] = [
            (str(script), n) for n in self._source(str(script)).statements
        ]
        seen: set[Symbol | Path] = set()
        files: set[Path] = set()
        while asked:
            found = asked.pop()
            if found in seen:
                continue
            seen.add(found)
            if isinstance(found, Path):
                files.add(found)
            else:
                files.add(self.paths[found[0]])
                if found not in self.followed:
                    self.followed[found] = list(self._references(*found))
                asked += [(found[0], EFFECTS), *self.followed[found]]
        return sorted(path.relative_to(self.folder).as_posix() for path in files - {script})

    def _references(self, home: str, name: str) -> Iterator[Symbol | Path]:
        """What the definition of a symbol refers to."""
        source = self._source(home)
        if name == ALL:
            yield from ((home, bound) for bound in (*source.statements, *source.imports))
        for node in source.statements.get(name, ()):
            yield from self._used(home, limited(node, self.using.get(f"{home}:{name}")))
        if name in source.imports:
            yield from self._resolved(home, source.imports[name])

    def _used(self, home: str, node: ast.AST) -> Iterator[Symbol | Path]:
        """What a piece of a module refers to."""
        source, uses = self._source(home), list(references(node))
        bound = dict(source.imports)
        for use in uses:
            if isinstance(use, IMPORTS):
                bound |= imported(use, source.package)
        for use in uses:
            if isinstance(use, str):
                yield from self._named_by(home, use)
            elif isinstance(use, list):
                if use[0] in bound:
                    yield from self._resolved(home, bound[use[0]] + use[1:])
                elif use[0] in source.statements:
                    yield home, use[0]
                elif use[0] == "__spec__":  # the module starts itself as a process
                    yield home, MAIN

    def _named_by(self, home: str, text: str) -> Iterator[Symbol | Path]:
        """What a string refers to, if anything."""
        yield from self.data.get(text, ())
        if found := self.spelled.fullmatch(text):
            module, name, inside = found.groups()
            if name:
                yield from self._resolved(home, [module, name])
            elif inside:
                yield from ((other, ALL) for other in self.paths if other.startswith(text))
            elif module in self.paths:
                yield module, ALL

    def _resolved(self, home: str, parts: list[str]) -> Iterator[Symbol]:
        """The symbol behind a module and names taken of it, one of the other."""
        where, *names = parts
        if where.split(".")[0] != self.folder.name:
            return
        if where not in self.paths:
            raise ValueError(f"{self.paths[home]}: there is no module {where}")
        for name in names:
            source = self._source(where)
            # a package that imports a module of its own binds the module
            known = {**source.imports, **source.statements}
            if known.get(name) not in (None, [where, name]):
                yield where, name
                return
            if f"{where}.{name}" in self.paths:
                where = f"{where}.{name}"
                continue
            if name.startswith("__"):
                yield where, EFFECTS
            elif "__getattr__" in known:
                yield where, "__getattr__"
            else:
                raise ValueError(f"{self.paths[home]}: {where} does not define {name!r}")
            return
        yield where, ALL

    def _source(self, module: str) -> Source:
        if module not in self.sources:
            path = self.paths[module]
            package = module if path.stem == "__init__" else module.rpartition(".")[0]
            self.sources[module] = Source.read(path, package)
        return self.sources[module]


def _state(folders: Iterable[Path], limits: Mapping[str, list[str]]) -> str:
    """A digest of the names, sizes and times of all files."""
    found = [json.dumps(limits, sort_keys=True)]
    for path in _files(folders):
        status = os.stat(path)
        found.append(f"{path} {status.st_size} {status.st_mtime_ns}")
    return hashlib.sha256("\n".join(found).encode()).hexdigest()


def _files(folders: Iterable[Path]) -> list[str]:
    return sorted(
        os.path.join(where, name)
        for folder in folders
        for where, _, names in os.walk(folder)
        for name in names
        if not where.endswith("__pycache__")
    )
