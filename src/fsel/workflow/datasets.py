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
VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")  # of the environment, and what else

Section = Mapping[str, Any]


def kinds_of(dataset: Section) -> list[str]:
    """List where an entry says that its captures come from: one of `KINDS`, unless it is wrong.

    A key that is null says nothing, but for a `root` alone: one that is not set yet.
    """
    given = [kind for kind in KINDS if dataset.get(kind) is not None]
    return given or (["root"] if "root" in dataset else [])


def count_of(entry: Section, role: str) -> int:
    """Number of scenes with a role that a dataset of the configuration has, there or not."""
    scenes = entry["scenes"]
    if isinstance(scenes, list):
        scenes = {"evaluation": scenes}
    found = scenes.get(role, 0)
    return found if isinstance(found, int) else len(found)


@dataclass(frozen=True)
class Datasets:
    """The datasets that are there, and the pages that the others come from.

    Attributes:
        entries: name -> entry of the configuration, in the order of the tables.
        sources: name -> page, archives and folders of a dataset, `config/sources.yaml`.
        missing: name -> why it is not there, in words.
        labels_missing: printed names of those.
    """

    entries: Mapping[str, Section]
    sources: Mapping[str, Section]
    missing: Mapping[str, str]
    labels_missing: tuple[str, ...]

    @classmethod
    def of(cls, entries: Mapping[str, Section], sources: Mapping[str, Section]) -> Datasets:
        """Those of a configuration, parted into what is there and what is not."""
        placed = {name: _placed(entry) for name, entry in entries.items()}
        missing = {
            name: f"datasets.{name}.root {_looked_for(entry['root'], placed[name]['root'])}"
            f"{origin(entry, sources)}"
            for name, entry in entries.items()
            if kinds_of(entry) == ["root"]
            and not (placed[name]["root"] and Path(placed[name]["root"]).is_dir())
        }
        here = {name: entry for name, entry in placed.items() if name not in missing}
        labels = tuple(entries[name]["label"] for name in missing)
        return cls(here, sources, missing, labels)

    def scenes(self, dataset: str, role: str) -> list[str]:
        """Names of a dataset's scenes with a role, in order."""
        entry = self.entries[dataset]
        roles = entry["scenes"]
        if isinstance(roles, list):
            roles = {"evaluation": roles}
        listed = roles.get(role, [])
        if not isinstance(listed, int):
            return list(listed)
        if kinds_of(entry) == ["embedded"]:
            return [f"{role}{number:02d}" for number in range(listed)]
        return self._counted(dataset, role)

    def role_of(self, dataset: str, scene: str) -> str:
        """The role of a scene."""
        return next(role for role in ROLES if scene in self.scenes(dataset, role))

    def _counted(self, name: str, role: str) -> list[str]:
        """Scenes with a role where the configuration says how many there are of each."""
        numbers, start = self.entries[name]["scenes"], 0
        for earlier in COUNTED:
            stop = start + numbers.get(earlier, 0)
            if earlier == role:
                break
            start = stop
        present = self._present(name)
        if stop > len(present):
            refuse(
                f"datasets.{name}.scenes asks for {sum(numbers.values())} scenes, {len(present)} "
                "are there",
                "lower the numbers, or name the scenes",
            )
        return present[start:stop]

    def _present(self, name: str) -> list[str]:
        """Folders below the root of a dataset in natural order, or the scenes that are fetched."""
        entry = self.entries[name]
        if kinds_of(entry) == ["fetch"]:
            return list(self.sources[entry["fetch"]]["scenes"])
        folders = [path.name for path in Path(entry["root"]).iterdir() if path.is_dir()]
        return sorted((name for name in folders if not name.startswith(".")), key=natural)

    def raw_capture(self, dataset: str, scene: str) -> str:
        """Folder of a scene as its dataset is distributed."""
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
        """Arguments of `fsel.captures.layouts.protocol.read_protocol`; none without a protocol."""
        file = self.entries[dataset].get("protocol")
        if not file:
            return {}
        return {"file": file, "scene": scene, "folder": self.raw_capture(dataset, scene)}

    def archive_of(self, dataset: str, scene: str) -> str:
        """File name of the archive that holds a fetched scene."""
        source = self.entries[dataset]["fetch"]
        return _archive(source, self.sources[source]["scenes"][scene]["url"])

    def archive(self, name: str) -> dict[str, str]:
        """Address and checksum of an archive, by its file name."""
        scenes = [(s, scene) for s in self.sources for scene in self.sources[s]["scenes"].values()]
        return next(
            {"url": scene["url"], "sha256": scene["sha256"]}
            for source, scene in scenes
            if name == _archive(source, scene["url"])
        )

    def fetched(self, dataset: str, scene: str) -> Section:
        """Entry of a fetched scene in `config/sources.yaml`."""
        source: Section = self.sources[self.entries[dataset]["fetch"]]
        return source["scenes"][scene]

    def names(self, kind: str = "") -> str:
        """Pattern of the datasets of a kind, or of all; it matches nothing where there is none.

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


def _placed(entry: Section) -> Section:
    """The same entry, variables of the environment put into its root: `${NAME:-other}`."""
    if not entry.get("root"):
        return entry
    root = VARIABLE.sub(lambda found: os.environ.get(found[1]) or found[2] or "", entry["root"])
    return {**entry, "root": root}


def _looked_for(written: str | None, root: str | None) -> str:
    """The folder of a dataset as it is written, and where that is."""
    if not root:
        return f"is {written}, which is empty" if written else "is not set"
    return f"{written} (no folder {Path(root).resolve()})"


def origin(entry: Section, sources: Mapping[str, Section]) -> str:
    """Say how to get a dataset that is not there, in words."""
    if "page" in entry:
        return f"; {entry['page']}"
    source = sources.get(entry["layout"])
    return f"; {source['page']}, expected below root: {source['expects']}" if source else ""


def _archive(source: str, url: str) -> str:
    return f"{source}_{url.rsplit('/', 1)[-1]}"
