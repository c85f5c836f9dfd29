"""Checks for statements of a configuration that do not fit together: refused before any job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fsel.captures.layouts import LAYOUTS
from fsel.workflow.datasets import KINDS, ROLES, Datasets, Section, kinds_of, origin
from fsel.workflow.refusal import refuse


def check_kind(name: str, entry: Section) -> None:
    """Refuse an entry that does not say where its captures come from, or says it twice."""
    if len(kinds_of(entry)) != 1:
        refuse(
            f"datasets.{name} needs exactly one of `embedded`, `root` and `fetch`, got "
            f"{[kind for kind in KINDS if kind in entry]}",
            "`embedded: {family: ...}` generates captures, `root: folder` reads them from disk, "
            "`fetch: source` downloads them; `fetch: null` takes one of another file back",
        )


def check_datasets(datasets: Datasets) -> None:
    """Refuse entries that no job could serve."""
    for name, entry in datasets.entries.items():
        where, (kind,) = f"datasets.{name}", kinds_of(entry)
        if kind == "fetch":
            _check_source(where, entry, datasets.sources)
        _check_numbers(where, entry)
        named = [scene for role in ROLES for scene in datasets.scenes(name, role)]
        if len(set(named)) < len(named):
            refuse(f"{where}.scenes names a scene twice: {named}", "give each scene one role")
        _check_reading(where, entry)
        _check_objects(where, entry, datasets.scenes(name, "object"))
        if kind == "root":
            _check_folders(where, entry, named, datasets.sources)
        if kind == "fetch":
            _check_fetched(where, entry, named, datasets.sources)


def check_protocols(datasets: Datasets, draws: int, budgets: Sequence[int]) -> None:
    """Refuse protocols that are not there, or do not go with what else is configured."""
    for name, entry in datasets.entries.items():
        where, file = f"datasets.{name}.protocol", entry.get("protocol")
        if not file:
            continue
        if not Path(file).is_file():
            refuse(f"{where} is {file}, not a file", "it comes with Long-LRM's repository, in data")
        if kinds_of(entry) != ["root"] or entry["layout"] != "dl3dv" or draws != 1:
            refuse(
                f"{where} has one draw of targets from a `root` in layout dl3dv; got "
                f"{kinds_of(entry)[0]}, layout {entry['layout']} and draws {draws}",
                "give it a configuration of its own, with `draws: 1` and budgets 16 and 32",
            )
        if not {16, 32} & set(budgets):
            refuse(f"{where} lists 16 and 32 frames, and budgets are {budgets}", "add one of them")


def _check_numbers(where: str, entry: Section) -> None:
    roles = entry["scenes"] if isinstance(entry["scenes"], dict) else {}
    embedded = kinds_of(entry) == ["embedded"]
    numbers = {isinstance(given, int) for given in roles.values()}
    if len(numbers) > 1 or (embedded and numbers != {True}):
        refuse(
            f"{where}.scenes is {entry['scenes']}",
            "embedded datasets take a number of scenes for every role, others that or names",
        )
    if embedded and entry["layout"] == "auto":
        refuse(f"{where}.layout is `auto`", "name the layout that embedded captures are written in")


def _check_reading(where: str, entry: Section) -> None:
    """Refuse what the layout's reader would refuse later."""
    if (entry["poses"] == "file") != ("model" in entry):
        refuse(
            f"{where}.poses is {entry['poses']!r} and model {entry.get('model')!r}",
            "`poses: file` needs `model`, a folder inside each scene, and nothing else does",
        )
    if entry["layout"] == "auto":
        return
    for key in entry["reading"]:
        if key not in LAYOUTS[entry["layout"]].options:
            takes = [name for name, layout in LAYOUTS.items() if key in layout.options]
            refuse(
                f"{where}.reading.{key}: layout {entry['layout']} does not take it",
                f"only {', '.join(takes)} does",
            )


def _check_objects(where: str, entry: Section, scenes: list[str]) -> None:
    """Refuse ScanNet scenes of which nobody says what the object is."""
    instance = entry["reading"].get("instance", {})
    if entry["layout"] != "scannet" or not isinstance(instance, dict):
        return
    if missing := [scene for scene in scenes if scene not in instance]:
        refuse(
            f"{where}.reading.instance: no object of {missing}",
            "give the value in instance-filt of the object, one for all or one a scene",
        )


def _check_folders(
    where: str, entry: Section, named: list[str], sources: Mapping[str, Section]
) -> None:
    root = Path(entry["root"])
    if missing := [scene for scene in named if not (root / scene).is_dir()]:
        present = sorted(path.name for path in root.iterdir() if path.is_dir())
        refuse(
            f"{where}.scenes: no folders {missing} in {root}{origin(entry, sources)}",
            f"the folders there are {present}",
        )


def _check_source(where: str, entry: Section, sources: Mapping[str, Section]) -> None:
    """Refuse a source that may not be fetched by a program."""
    source = sources.get(entry["fetch"], {"scenes": {}, "page": "", "expects": ""})
    if not source["scenes"]:
        offered = [name for name in sources if sources[name]["scenes"]]
        refuse(
            f"{where}.fetch is {entry['fetch']!r}, which may not be downloaded by a program",
            f"get it from {source['page']}, put it as {source['expects']} below a folder, and "
            "name that folder as `root`"
            if source["page"]
            else f"these may: {offered}",
        )


def _check_fetched(
    where: str, entry: Section, named: list[str], sources: Mapping[str, Section]
) -> None:
    source = sources[entry["fetch"]]
    if missing := sorted(set(named) - set(source["scenes"])):
        refuse(
            f"{where}.scenes: {missing} are not among what may be fetched of {entry['fetch']}",
            f"these are: {sorted(source['scenes'])}; the others are at {source['page']}",
        )


def check_search(search: Section) -> None:
    """Refuse numbers of a search that do not fit together."""
    if search["kept"] > search["stored"]:
        refuse(
            f"search: kept is {search['kept']}, more than stored, {search['stored']}",
            "only stored subsets can be imitated",
        )
    if search["farthest"] + search["uniform"] > search["population"]:
        refuse(
            f"search: farthest and uniform are {search['farthest']} and {search['uniform']}, "
            f"more than population, {search['population']}",
            "the rest of the first generation is random",
        )


def check_scenes(datasets: Datasets, trained: str) -> None:
    """Refuse an experiment without scenes to evaluate on, or with others to train on than named."""
    trains = any(datasets.scenes(name, "train") for name in datasets.entries)
    if trained not in datasets.entries or (trains and not datasets.scenes(trained, "train")):
        refuse(
            f"training.dataset is {trained!r}, which has no `train` scenes among the datasets "
            f"{list(datasets.entries)}",
            f"add `{trained}` with train scenes, or name another dataset; without any train scenes "
            "the scorers that ship are measured",
        )
    if not any(datasets.scenes(name, "evaluation") for name in datasets.entries):
        refuse("no dataset has evaluation scenes", "the tables need at least one")


def check_frames(datasets: Datasets, needed: Mapping[str, int], frames: int) -> None:
    """Refuse embedded captures that are too short.

    Args:
        datasets: those that are there.
        needed: role -> least frames of its scenes.
        frames: of an embedded capture.
    """
    for name, entry in datasets.entries.items():
        for role in ROLES:
            if kinds_of(entry) != ["embedded"] or not datasets.scenes(name, role):
                continue
            if frames < needed[role]:
                refuse(
                    f"embedded.frames is {frames}, the {role} scenes of {name} need "
                    f"{needed[role]}: targets, as many proxies, and the largest budget",
                    "raise embedded.frames, or lower targets or budgets",
                )


def frames_needed(config: Mapping[str, Any], role: str) -> int:
    """Least frames of a scene: targets, their proxies, and candidates for the largest budget."""
    if role == "evaluation":
        return 2 * int(config["targets"]) + max(max(config["budgets"]), config["search"]["k"])
    if role == "object":
        return 2 * int(config["targets"]) + budget_near(config["budgets"], 30)
    targets = max(4, int(0.15 * max(config["coverages"]) + 0.5))
    labels = 2 * targets + int(config["search"]["k"])
    refinement = config["refinement"]
    if not refinement["seeds"]:
        return labels
    return max(labels, 2 * refinement["targets"] + max(refinement["budgets"]))


def budget_near(budgets: list[int], k: int) -> int:
    """The largest budget up to a number of frames, or the smallest."""
    return max([budget for budget in budgets if budget <= k] or [min(budgets)])
