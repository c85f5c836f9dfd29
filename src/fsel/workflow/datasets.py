"""The datasets of a configuration: their scenes, and where their captures come from."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

from fsel.captures.layouts import LAYOUTS
from fsel.core.names import natural
from fsel.workflow.schema import Refusal

ROLES = ("train", "validation", "evaluation", "object")
COUNTED = ("evaluation", "validation", "train", "object")  # the order in which folders are taken
KINDS = ("embedded", "fetch", "root")
READING = ("layout", "poses", "model", "points", "every", "max_error", "reading")
VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")  # of the environment, and its default

Section = Mapping[str, Any]


def kinds_of(dataset: Section) -> list[str]:
    """List where an entry says that its captures come from, of `KINDS`; a key that is null does not
    count, but for a `root` alone, which is not set yet."""
    given = [kind for kind in KINDS if dataset.get(kind) is not None]
    return given or (["root"] if "root" in dataset else [])


def roles_of(entry: Section) -> Mapping[str, Any]:
    """Return role -> names of scenes, how many, or `all`; without a role they are evaluated."""
    scenes = entry["scenes"]
    return scenes if isinstance(scenes, dict) else {"evaluation": scenes}


def roots_of(entry: Section) -> list[str]:
    """List the folders that hold an entry's scenes, none for other kinds."""
    root = entry.get("root") or []
    return [root] if isinstance(root, str) else list(root)


def folder_of(entry: Section, scene: str) -> Path:
    """Return the folder of a scene on disk; of several roots, one begins the scene's name."""
    roots = roots_of(entry)
    root = next(root for root in roots if scene.startswith(_prefix(roots, root)))
    return Path(root, scene.removeprefix(_prefix(roots, root)))


@dataclass(frozen=True)
class Datasets:
    """The datasets that are there, and the pages that the others come from."""

    entries: Mapping[str, Section]  # name -> entry of the configuration, in the order of the tables
    sources: Mapping[str, Section]  # name -> page, archives and folders: `config/sources.yaml`
    missing: Mapping[str, str]  # name -> why it is not there
    labels_missing: tuple[str, ...]  # printed names of those

    @classmethod
    def of(
        cls, entries: Mapping[str, Section], sources: Mapping[str, Section], trusted: bool = False
    ) -> Datasets:
        """Part the datasets of a configuration into what is there and what is not, and refuse an
        entry that no job could serve; `trusted` ones are taken to be there."""
        placed = {name: _placed(name, entry) for name, entry in entries.items()}
        missing = {}
        for name, entry in entries.items():
            roots = roots_of(placed[name]) or [""]
            root = next((root for root in roots if not (root and Path(root).is_dir())), None)
            if trusted or kinds_of(entry) != ["root"] or root is None:
                continue
            said = f"{entry['root']} (no folder {Path(root).resolve()})" if root else "is not set"
            if entry["root"] and not root:
                said = f"is {entry['root']}, which is empty"
            missing[name] = f"datasets.{name}.root {said}{_origin(entry, sources)}"
        here = {name: entry for name, entry in placed.items() if name not in missing}
        found = cls(here, sources, missing, tuple(entries[name]["label"] for name in missing))
        for name in () if trusted else here:
            found._check(name)
        return found

    def _check(self, name: str) -> None:
        """Refuse a dataset whose scenes are not there, before jobs of the others have run."""
        entry, where = self.entries[name], f"datasets.{name}"
        if kinds_of(entry) == ["fetch"]:
            self._check_source(where, entry["fetch"])
        named = [scene for role in ROLES for scene in self.scenes(name, role)]
        if len(set(named)) < len(named):
            raise Refusal(f"{where}.scenes names a scene twice: {named}", "one role each")
        if kinds_of(entry) == ["embedded"]:
            return
        there, layout = self._present(name), entry["layout"]
        if absent := sorted(set(named) - set(there)):
            place = entry.get("root") or f"what may be fetched of {entry['fetch']}"
            raise Refusal(
                f"{where}.scenes: no {absent} in {place}{_origin(entry, self.sources)}",
                f"those there are {there}",
            )
        knows = Path.is_dir if layout == "auto" else LAYOUTS[layout].recognises
        several = named if len(roots_of(entry)) > 1 else []
        if other := [scene for scene in several if not knows(folder_of(entry, scene))]:
            raise Refusal(
                f"{where}.root is {entry['root']}, and {other} do not have the layout {layout}",
                "docs/datasets.md says what each expects; no two roots may have one name",
            )

    def _check_source(self, where: str, name: str) -> None:
        source = self.sources.get(name, {"scenes": {}})
        if not source["scenes"]:
            offered = [each for each in self.sources if self.sources[each]["scenes"]]
            raise Refusal(
                f"{where}.fetch is {name!r}, which no program may download",
                f"get it from {source['page']} and name its folder as `root`"
                if "page" in source
                else f"these may be fetched: {offered}",
            )

    def scenes(self, dataset: str, role: str) -> list[str]:
        """Return the names of a dataset's scenes with a role, in order."""
        entry = self.entries[dataset]
        listed = roles_of(entry).get(role, [])
        if listed == "all":
            return self._present(dataset)
        if not isinstance(listed, int):
            return list(listed)
        if kinds_of(entry) == ["embedded"]:
            return [f"{role}{number:02d}" for number in range(listed)]
        counts = {r: n for r, n in roles_of(entry).items() if isinstance(n, int)}
        present, total = self._present(dataset), sum(counts.values())
        if total > len(present):
            raise Refusal(
                f"datasets.{dataset}.scenes needs {total} scenes, but only {len(present)} exist",
                "lower the numbers, or name the scenes",
            )
        start = sum(counts.get(earlier, 0) for earlier in COUNTED[: COUNTED.index(role)])
        return present[start : start + listed]

    def role_of(self, dataset: str, scene: str) -> str:
        """Return the role of a scene."""
        return next(role for role in ROLES if scene in self.scenes(dataset, role))

    def _present(self, name: str) -> list[str]:
        """List the folders below a dataset's root in natural order, of several roots the first of
        each, then the second, as `root-folder`; or what may be fetched."""
        entry = self.entries[name]
        if kinds_of(entry) == ["fetch"]:
            return list(self.sources[entry["fetch"]]["scenes"])
        roots, each = roots_of(entry), []
        for root in roots:
            folders = [f.name for f in os.scandir(root) if f.is_dir() and f.name[0] != "."]
            each.append([_prefix(roots, root) + f for f in sorted(folders, key=natural)])
        return [scene for turn in zip_longest(*each) for scene in turn if scene]

    def raw_capture(self, wildcards: Any) -> str:
        """Return the folder of a scene as its dataset is distributed."""
        entry = self.entries[wildcards.dataset]
        if kinds_of(entry) == ["root"]:
            return str(folder_of(entry, wildcards.scene))
        return f"<results>/data/{wildcards.dataset}/{wildcards.scene}"

    def reading(self, wildcards: Any) -> dict[str, Any]:
        """Return how a scene is read; where every scene has an object of its own, which one."""
        entry = self.entries[wildcards.dataset]
        reading = {key: entry[key] for key in READING if key in entry}
        instance = entry["reading"].get("instance")
        if isinstance(instance, dict):
            others = {key: value for key, value in entry["reading"].items() if key != "instance"}
            own = {"instance": instance[wildcards.scene]} if wildcards.scene in instance else {}
            reading["reading"] = others | own
        return reading

    def fetched(self, wildcards: Any) -> Section:
        """Return the entry of a fetched scene in `config/sources.yaml`."""
        source: Section = self.sources[self.entries[wildcards.dataset]["fetch"]]
        return source["scenes"][wildcards.scene]

    def archive_of(self, wildcards: Any) -> str:
        """Return the path of the archive that holds a fetched scene."""
        source = self.entries[wildcards.dataset]["fetch"]
        return f"<downloads>/{_archive(source, self.fetched(wildcards)['url'])}"

    def archive(self, wildcards: Any) -> Section:
        """Return the entry of a scene in an archive, by the archive's file name."""
        return next(
            scene
            for source, entry in self.sources.items()
            for scene in entry["scenes"].values()
            if wildcards.archive == _archive(source, scene["url"])
        )

    def names(self, kind: str = "") -> str:
        """Return a pattern of the datasets of a kind, of those with objects, or of all."""
        names = [
            re.escape(name)
            for name, entry in self.entries.items()
            if kind in ("", *kinds_of(entry)) or (kind == "object" and self.scenes(name, "object"))
        ]
        return "|".join(names) or "(?!)"  # which matches nothing


def _placed(name: str, entry: Section) -> Section:
    """Return an entry with variables of the environment put into its root: `${NAME:-other}`."""
    if len(kinds_of(entry)) != 1:
        raise Refusal(
            f"datasets.{name} needs exactly one of `embedded`, `root` and `fetch`, got "
            f"{[kind for kind in KINDS if kind in entry]}",
            "`embedded: {family: ...}` generates captures, `root: folder` reads them from disk, "
            "`fetch: source` downloads them; `fetch: null` takes one of another file back",
        )
    if not entry.get("root"):
        return entry
    roots = [
        VARIABLE.sub(lambda found: os.environ.get(found[1]) or found[2] or "", root)
        for root in roots_of(entry)
    ]
    return {**entry, "root": roots if len(roots) > 1 else roots[0]}


def _prefix(roots: list[str], root: str) -> str:
    """Return what the names of a root's scenes begin with where there are several."""
    return f"{Path(root).name}-" if len(roots) > 1 else ""


def _origin(entry: Section, sources: Mapping[str, Section]) -> str:
    """Say how to get a dataset that is not there."""
    if "page" in entry:
        return f"; {entry['page']}"
    source = sources.get(entry["layout"])
    return f"; {source['page']}, expected below root: {source['expects']}" if source else ""


def _archive(source: str, url: str) -> str:
    return f"{source}_{url.rsplit('/', 1)[-1]}"
