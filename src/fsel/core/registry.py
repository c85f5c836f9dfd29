"""Registries: names, and what each stands for, imported when it is first used."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from difflib import get_close_matches
from functools import cached_property
from importlib import import_module
from importlib.metadata import entry_points
from operator import attrgetter
from typing import Any, TypeVar

from fsel.core.wording import counted

Entry = TypeVar("Entry")
Settings = TypeVar("Settings")


class Registry(MutableMapping[str, Entry]):
    """Name -> entry, in the order of the tables; listing the names imports nothing.

    Args:
        kind: what its entries are, for error messages.
        homes: name -> `module:attribute`. Adding an entry is one line here.
        group: of entry points by which other installed packages add entries.
        ahead: whether these come before the homes.

    Entries that are set directly need no home.
    """

    def __init__(
        self, kind: str, homes: Mapping[str, str], *, group: str | None = None, ahead: bool = False
    ) -> None:
        self.kind, self._own, self._group, self._ahead = kind, dict(homes), group, ahead
        self._found: dict[str, Entry] = {}

    @cached_property
    def homes(self) -> dict[str, str]:
        """Name -> `module:attribute`, of other packages too; ValueError for a name given twice."""
        added: dict[str, str] = {}
        for point in entry_points(group=self._group) if self._group else ():
            if point.name in self._own or added.get(point.name, point.value) != point.value:
                package = "an installed package" if point.dist is None else point.dist.name
                raise ValueError(
                    f"{package}: {self.kind} {point.name!r} ({point.value}) has the name of "
                    "another. Hint: rename it in the package's entry points, or uninstall it"
                )
            added[point.name] = point.value
        return added | self._own if self._ahead else self._own | added

    def __getitem__(self, name: str) -> Entry:
        """Return the entry; KeyError for a name that is not registered, else see `checked`."""
        if name in self._found:
            return self._found[name]
        home = self.homes[name]
        module, _, attribute = home.partition(":")
        try:
            entry: Entry = attrgetter(attribute)(import_module(module))
        except ModuleNotFoundError as error:
            raise ImportError(
                f"{self.kind} {name!r} ({home}) needs {error.name}, which is not installed"
            ) from error
        except AttributeError as error:
            raise ImportError(f"{self.kind} {name!r} ({home}): {error}") from error
        called = getattr(entry, "name", name) if name not in self._own else name
        if isinstance(called, str) and called != name:  # of another package
            raise ValueError(f"{self.kind} {name!r} ({home}) calls itself {called!r}")
        self._found[name] = entry
        return entry

    def __repr__(self) -> str:
        return f"<{counted(len(self), self.kind)}: {', '.join(self)}>"

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
        """Return the entry; ValueError, listing the names, for one that is not registered, and
        ImportError, by name, for one that needs a package that is not installed."""
        if name not in self.homes:
            raise unknown(self.kind, name, self.homes)
        return self[name]


def closest(name: str, allowed: Iterable[str]) -> str:
    """Return the allowed name that is most like another; empty where none is."""
    return next(iter(get_close_matches(str(name).lower(), allowed, 1)), "")


def unknown(kind: str, name: str, allowed: Iterable[str]) -> ValueError:
    """Make the refusal of the name of a kind of thing: what is allowed, and which was meant."""
    names = list(allowed)
    near = closest(name, names)
    hint = f". Hint: did you mean {near!r}?" if near else ""
    return ValueError(f"{kind} is {name!r}; allowed: {', '.join(names)}{hint}")


def settings_from(kind: Callable[..., Settings], given: Mapping[str, Any]) -> Settings:
    """Return a dataclass of settings with the given fields; ValueError for a name that is none."""
    allowed = list(inspect.signature(kind).parameters)
    for name in given:
        if name not in allowed:
            raise ValueError(f"no setting {name!r}; allowed: {', '.join(allowed)}")
    return kind(**given)
