"""The datasets of a configuration: their scenes, and where their captures come from."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsel.core.names import natural
from fsel.workflow.refusal import refuse

ROLES = ("train", "validation", "evaluation", "object")
COUNTED = ("evaluation", "validation", "train", "object")  # the order in which folders are taken
KINDS = ("embedded", "fetch", "root")
READING = ("layout", "poses", "model", "points", "every", "max_error", "reading")
VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")  # of the environment, and its default

Section = Mapping[str, Any]


def kinds_of(dataset: Section) -> list[str]:
    """List where an entry says that its captures come from: one of `KINDS`, unless it is wrong.

    A key that is null does not count, but for a `root` alone: one that is not set yet.
    """
    given = [kind for kind in KINDS if dataset.get(kind) is not None]
    return given or (["root"] if "root" in dataset else [])


def roles_of(entry: Section) -> Mapping[str, Any]:
    """Return role -> names of scenes, or how many; a list alone is for evaluation."""
    scenes = entry["scenes"]
    return {"evaluation": scenes} if isinstance(scenes, list) else scenes


@dataclass(frozen=True)
class Datasets:
    """The datasets that are there, and the pages that the others come from.

    Attributes:
        entries: name -> entry of the configuration, in the order of the tables.
        sources: name -> page, archives and folders of a dataset, `config/sources.yaml`.
        missing: name -> why it is not there.
        labels_missing: printed names of those.
    """

    entries: Mapping[str, Section]
    sources: Mapping[str, Section]
    missing: Mapping[str, str]
    labels_missing: tuple[str, ...]

    @classmethod
    def of(cls, entries: Mapping[str, Section], sources: Mapping[str, Section]) -> Datasets:
        """Part the datasets of a configuration into what is there and what is not.

        Raises:
            Refusal: for an entry that no job could serve.
        """
        placed = {name: _placed(name, entry) for name, entry in entries.items()}
        missing = {
            name: f"datasets.{name}.root {_sought(entry['root'], placed[name]['root'])}"
            f"{_origin(entry, sources)}"
            for name, entry in entries.items()
            if kinds_of(entry) == ["root"]
            and not (placed[name]["root"] and Path(placed[name]["root"]).is_dir())
        }
        here = {name: entry for name, entry in placed.items() if name not in missing}
        found = cls(here, sources, missing, tuple(entries[name]["label"] for name in missing))
        for name in here:
            found._check(name)
        return found

    def _check(self, name: str) -> None:
        """Refuse a dataset whose scenes are not there, before jobs of the others have run."""
        entry, where = self.entries[name], f"datasets.{name}"
        if kinds_of(entry) == ["fetch"]:
            self._check_source(where, entry["fetch"])
        named = [scene for role in ROLES for scene in self.scenes(name, role)]
        if len(set(named)) < len(named):
            refuse(f"{where}.scenes names a scene twice: {named}", "give each scene one role")
        if kinds_of(entry) == ["embedded"]:
            return
        there, root = self._present(name), entry.get("root")
        if root:
            absent = [scene for scene in named if not Path(root, scene).is_dir()]
        else:
            absent = sorted(set(named) - set(there))
        if absent:
            place = root or f"what may be fetched of {entry['fetch']}"
            refuse(
                f"{where}.scenes: no {absent} in {place}{_origin(entry, self.sources)}",
                f"those there are {there}",
            )

    def _check_source(self, where: str, name: str) -> None:
        source = self.sources.get(name, {"scenes": {}})
        if not source["scenes"]:
            offered = [each for each in self.sources if self.sources[each]["scenes"]]
            refuse(
                f"{where}.fetch is {name!r}, which no program may download",
                f"get it from {source['page']} and name its folder as `root`"
                if "page" in source
                else f"these may be fetched: {offered}",
            )

    def scenes(self, dataset: str, role: str) -> list[str]:
        """Return the names of a dataset's scenes with a role, in order."""
        entry = self.entries[dataset]
        listed = roles_of(entry).get(role, [])
        if not isinstance(listed, int):
            return list(listed)
        if kinds_of(entry) == ["embedded"]:
            return [f"{role}{number:02d}" for number in range(listed)]
        return self._counted(dataset, role)

    def role_of(self, dataset: str, scene: str) -> str:
        """Return the role of a scene."""
        return next(role for role in ROLES if scene in self.scenes(dataset, role))

    def _counted(self, name: str, role: str) -> list[str]:
        """Return the scenes with a role of which the configuration says how many there are."""
        counts = {r: n for r, n in roles_of(self.entries[name]).items() if isinstance(n, int)}
        present, total = self._present(name), sum(counts.values())
        if total > len(present):
            refuse(
                f"datasets.{name}.scenes asks for {total} scenes, {len(present)} are there",
                "lower the numbers, or name the scenes",
            )
        start = sum(counts.get(earlier, 0) for earlier in COUNTED[: COUNTED.index(role)])
        return present[start : start + counts[role]]

    def _present(self, name: str) -> list[str]:
        """List the folders below a dataset's root in natural order, or what may be fetched."""
        entry = self.entries[name]
        if kinds_of(entry) == ["fetch"]:
            return list(self.sources[entry["fetch"]]["scenes"])
        folders = [path.name for path in Path(entry["root"]).iterdir() if path.is_dir()]
        return sorted((name for name in folders if not name.startswith(".")), key=natural)

    def raw_capture(self, dataset: str, scene: str) -> str:
        """Return the folder of a scene as its dataset is distributed."""
        if kinds_of(self.entries[dataset]) == ["root"]:
            return str(Path(self.entries[dataset]["root"], scene))
        return f"<results>/data/{dataset}/{scene}"

    def reading(self, dataset: str, scene: str) -> dict[str, Any]:
        """Return how a scene is read; where every scene has an object of its own, which one."""
        entry = self.entries[dataset]
        reading = {key: entry[key] for key in READING if key in entry}
        instance = entry["reading"].get("instance")
        if isinstance(instance, dict):
            others = {key: value for key, value in entry["reading"].items() if key != "instance"}
            own = {"instance": instance[scene]} if scene in instance else {}
            reading["reading"] = others | own
        return reading

    def protocol(self, dataset: str, scene: str) -> dict[str, str]:
        """Return arguments of `fsel.captures.layouts.dl3dv.read_protocol`, if there is one."""
        file = self.entries[dataset].get("protocol")
        if not file:
            return {}
        return {"file": file, "scene": scene, "folder": self.raw_capture(dataset, scene)}

    def archive_of(self, dataset: str, scene: str) -> str:
        """Return the file name of the archive that holds a fetched scene."""
        source = self.entries[dataset]["fetch"]
        return _archive(source, self.sources[source]["scenes"][scene]["url"])

    def archive(self, name: str) -> dict[str, str]:
        """Return the address and the checksum of an archive, by its file name."""
        return next(
            {"url": scene["url"], "sha256": scene["sha256"]}
            for source, entry in self.sources.items()
            for scene in entry["scenes"].values()
            if name == _archive(source, scene["url"])
        )

    def fetched(self, dataset: str, scene: str) -> Section:
        """Return the entry of a fetched scene in `config/sources.yaml`."""
        source: Section = self.sources[self.entries[dataset]["fetch"]]
        return source["scenes"][scene]

    def names(self, kind: str = "") -> str:
        """Return a pattern of the datasets of a kind, or of all; it matches nothing for none.

        `object` is the kind of those with masks of objects.
        """
        patterns = [
            re.escape(name)
            for name, entry in self.entries.items()
            if not kind
            or kinds_of(entry) == [kind]
            or (kind == "object" and self.scenes(name, "object"))
        ]
        return "|".join(patterns) or "(?!)"


def _placed(name: str, entry: Section) -> Section:
    """Return an entry with variables of the environment put into its root: `${NAME:-other}`."""
    if len(kinds_of(entry)) != 1:
        refuse(
            f"datasets.{name} needs exactly one of `embedded`, `root` and `fetch`, got "
            f"{[kind for kind in KINDS if kind in entry]}",
            "`embedded: {family: ...}` generates captures, `root: folder` reads them from disk, "
            "`fetch: source` downloads them; `fetch: null` takes one of another file back",
        )
    if not entry.get("root"):
        return entry
    root = VARIABLE.sub(lambda found: os.environ.get(found[1]) or found[2] or "", entry["root"])
    return {**entry, "root": root}


def _sought(written: str | None, root: str | None) -> str:
    """Return the folder of a dataset as it is written, and where that is."""
    if not root:
        return f"is {written}, which is empty" if written else "is not set"
    return f"{written} (no folder {Path(root).resolve()})"


def _origin(entry: Section, sources: Mapping[str, Section]) -> str:
    """Say how to get a dataset that is not there."""
    if "page" in entry:
        return f"; {entry['page']}"
    source = sources.get(entry["layout"])
    return f"; {source['page']}, expected below root: {source['expects']}" if source else ""


def _archive(source: str, url: str) -> str:
    return f"{source}_{url.rsplit('/', 1)[-1]}"
