"""Registries: names, and what each stands for, imported when it is first used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from importlib import import_module
from typing import TypeVar

Entry = TypeVar("Entry")


class Registry(MutableMapping[str, Entry]):
    """Name -> entry, in the order of the tables; listing the names imports nothing.

    Args:
        kind: what its entries are, for error messages.
        homes: name -> `module:attribute`. Adding an entry is one line here.
        renamed: former name -> name, which the refusal of a former name says.

    Entries that are set by hand need no home.
    """

    def __init__(
        self, kind: str, homes: Mapping[str, str], renamed: Mapping[str, str] | None = None
    ) -> None:
        self.kind, self.homes, self.renamed = kind, dict(homes), dict(renamed or {})
        self._found: dict[str, Entry] = {}

    def __getitem__(self, name: str) -> Entry:
        """The entry.

        Raises:
            KeyError: for a name that is not registered.
            ImportError: when the entry needs a package that is not installed; it is named.
        """
        if name not in self._found:
            self._found[name] = self._imported(self.homes[name], name)
        return self._found[name]

    def _imported(self, home: str, name: str) -> Entry:
        module, _, attribute = home.partition(":")
        try:
            return getattr(import_module(module), attribute)
        except ModuleNotFoundError as error:
            raise ImportError(
                f"{self.kind} {name!r} ({home}) needs {error.name}, which is not installed"
            ) from error

    def __setitem__(self, name: str, entry: Entry) -> None:
        self.homes.setdefault(name, "")
        self._found[name] = entry

    def __delitem__(self, name: str) -> None:
        del self.homes[name]
        self._found.pop(name, None)

    def __contains__(self, name: object) -> bool:
        return name in self.homes

    def __iter__(self) -> Iterator[str]:
        return iter(self.homes)

    def __len__(self) -> int:
        return len(self.homes)

    def checked(self, name: str) -> Entry:
        """The entry.

        Raises:
            ValueError: for a name that is not registered; the message lists those that are.
            ImportError: as above.
        """
        if name not in self.homes:
            raise unknown(self.kind, name, self.homes, self.renamed)
        return self[name]


def unknown(kind: str, name: str, allowed: Iterable[str], renamed: Mapping[str, str]) -> ValueError:
    """Make the refusal of a name: what is allowed, and its new name if it had been one.

    Args:
        kind: what is named.
        name: that is not allowed.
        allowed: names.
        renamed: former name -> name.
    """
    hint = f". Hint: {name!r} is named {renamed[name]!r} now" if name in renamed else ""
    return ValueError(f"{kind} is {name!r}; allowed: {', '.join(allowed)}{hint}")
