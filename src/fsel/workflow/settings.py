"""The checked configuration: its scenes, problems and seeds."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import cycle, product
from pathlib import Path
from typing import Any, Self

from fsel.core.names import name_seed
from fsel.workflow.datasets import ROLES, Datasets, Section, kinds_of, roles_of
from fsel.workflow.schema import Refusal, complete, read_schema, read_yaml

PACKAGE = Path(__file__).resolve().parents[1]
PAGE = "config/README.md describes every key"
TRAINED = ("less_is_more", "less_is_more_no_appearance")  # policies with labels
Scene = tuple[str, str]  # dataset, scene
Locate = Callable[[str], str | Path]  # path in the repository of the workflow -> where it is


@dataclass(frozen=True)
class Settings:
    """A configuration with its defaults, whose parts fit together: scenes, problems and seeds."""

    config: Mapping[str, Any]  # every key with its value; `datasets` are those that are there
    locate: Locate
    datasets: Datasets
    reconstructors: Mapping[str, Section]  # those that evaluate, by name; the first labels too
    labeller: Section  # the reconstructor that labels
    without_lpips: str = ""  # why GMSD stands in the place of LPIPS; empty where it does not

    @classmethod
    def load(cls, config: dict[str, Any], locate: Locate, asks: bool = True) -> Self:
        """Put defaults into a configuration and take it apart, without datasets that are not there,
        which a job need not ask (it sees its inputs alone); refuse unknown keys, values, and keys
        that do not fit together."""
        complete(config, read_schema(locate("workflow/schemas/config.schema.yaml")), PAGE)
        path = Path(config["sources"] or locate("config/sources.yaml"))
        if not path.is_file():
            raise Refusal(f"sources is {path}, not a file", "leave it out for config/sources.yaml")
        sources = read_yaml(path)
        schema = read_schema(locate("workflow/schemas/sources.schema.yaml"))
        complete(sources, schema, f"in {path}", str(path))
        trusted = not asks and not config["allow_missing"]
        datasets = Datasets.of(config["datasets"], sources, trusted)
        named = named_reconstructors(config["reconstruction"], "reconstruction")
        search = dict(config["search"])
        labeller = search.pop("reconstruction") or next(iter(named.values()))
        own = {**config, "datasets": datasets.entries, "search": search}
        own |= _as_shipped(config, datasets.entries)
        return cls(own, locate, datasets, named, without_name(labeller))

    def check(self) -> None:
        """Refuse too few scenes or frames, which would only be seen after hours of work."""
        entries, search, draws = self.datasets.entries, self.config["search"], self.config["draws"]
        trains = any(self.scenes(name, "train") for name in entries)
        if self.trained not in entries or (trains and not self.scenes(self.trained, "train")):
            raise Refusal(
                f"training.dataset is {self.trained!r}, which has no `train` scenes among the "
                f"datasets {list(entries)}",
                "add it with train scenes, or name another; without any train scenes the scorers "
                "that ship are measured",
            )
        if not self.evaluation_scenes:
            raise Refusal("no dataset has evaluation scenes", "the tables need at least one")
        hold_out, least = self.config["hold_out"], min(self.config["budgets"])
        if hold_out["every"] and draws != 1:
            found = f"draws is {draws}, but hold_out.every allows only one"
            raise Refusal(found, "set `draws: 1`")
        if hold_out["every"] and hold_out["first"] >= least:
            found = f"hold_out.first is {hold_out['first']}, but the smallest budget is {least}"
            raise Refusal(found, "every method picks more than it begins with")
        if search["kept"] > search["stored"]:
            found = f"search: kept is {search['kept']}, more than stored, {search['stored']}"
            raise Refusal(found, "raise search.stored")
        for name, role in product(entries, ROLES):
            needed, embedded = self.frames_needed(role), kinds_of(entries[name]) == ["embedded"]
            if not embedded or not self.scenes(name, role):
                continue
            if (frames := self.embedded_frames(name)) < needed:
                raise Refusal(
                    f"embedded.frames is {frames}, the {role} scenes of {name} need {needed}: "
                    "targets, as many proxies, and the largest budget",
                    "raise embedded.frames, or lower targets or budgets",
                )

    @property
    def trained(self) -> str:
        """The dataset whose scenes are labelled."""
        return str(self.config["training"]["dataset"])

    def scenes(self, dataset: str, role: str) -> list[str]:
        """Return a dataset's scenes with a role; with folds, train scenes are evaluated too."""
        found, folds = self.datasets.scenes(dataset, role), self.config["training"]["folds"]
        crossed = folds and role == "evaluation" and dataset == self.trained
        return found + self.datasets.scenes(dataset, "train") if crossed else found

    def with_role(self, role: str) -> list[Scene]:
        """Return the scenes of all datasets with a role."""
        return [(d, scene) for d in self.datasets.entries for scene in self.scenes(d, role)]

    @cached_property
    def evaluation_scenes(self) -> list[Scene]:
        """The scenes that the tables are of."""
        return self.with_role("evaluation")

    def labels(self, names: Iterable[str] | None = None) -> dict[str, str]:
        """Map datasets, those in the tables by default, to their printed labels."""
        entries = self.datasets.entries
        chosen = [n for n in entries if self.scenes(n, "evaluation")] if names is None else names
        return {name: entries[name]["label"] for name in chosen}

    def places(self) -> dict[str, str]:
        """Map dataset/scene to the place of evaluation scenes that may share one with another."""
        places = {}
        for d, s in self.evaluation_scenes:
            given = self.datasets.entries[d].get("places", {})
            shared = f"{given}/{s}" if isinstance(given, str) else given.get(s)
            if shared is not None:
                places[f"{d}/{s}"] = shared
        return places

    def problems(self, draws: int | None = None) -> list[str]:
        """List dataset/scene/draw of every evaluation problem, or of those of the first draws."""
        count = self.config["draws"] if draws is None else draws
        return [f"{d}/{s}/draw{n}" for d, s in self.evaluation_scenes for n in range(count)]

    def searched_problems(self) -> list[str]:
        """List the problems of the labelled dataset's evaluation scenes that are searched."""
        draws = range(self.config["oracle"]["draws"])
        scenes = self.scenes(self.trained, "evaluation")
        return [f"{self.trained}/{scene}/draw{n}" for scene in scenes for n in draws]

    @cached_property
    def labelled(self) -> dict[str, str]:
        """Scene of the labelled dataset -> its role, `train` or `validation`."""
        roles = ("train", "validation")
        return {scene: role for role in roles for scene in self.scenes(self.trained, role)}

    @cached_property
    def folds(self) -> dict[Scene, str]:
        """Train scene -> its part of the cross-validation, `foldN/`; scenes of a place share it."""
        trained, count = self.trained, self.config["training"]["folds"]
        scenes = self.scenes(trained, "train") if count else []
        place_of = {(trained, s): self.places().get(f"{trained}/{s}", s) for s in scenes}
        distinct = list(dict.fromkeys(place_of.values()))
        return {s: f"fold{distinct.index(place) % count}/" for s, place in place_of.items()}

    def roles(self, fold: str) -> dict[str, str]:
        """Return the roles of the labelled scenes for the scorers of a fold: validation in it."""
        left_out = [scene for (_, scene), own in self.folds.items() if own == fold]
        return self.labelled | dict.fromkeys(left_out, "validation")

    @cached_property
    def coverages(self) -> dict[str, list[int]]:
        """Labelled scene -> its coverage levels: all, or one, in turn from scene to scene."""
        one = [[level] for level in self.config["coverage_turns"]]
        return dict(zip(self.labelled, cycle(one or [sorted(self.config["coverages"])])))

    def frames_needed(self, role: str) -> int:
        """Return the least frames of a scene: targets, their proxies, and the largest budget."""
        config = self.config
        budgets, k = config["budgets"], config["search"]["k"]
        if role == "evaluation":
            return int(2 * config["targets"] + max(*budgets, k))
        if role == "object":
            return int(2 * config["targets"] + self.budget_near(30))
        return 2 * max(4, int(0.15 * max(config["coverages"]) + 0.5)) + k

    def budget_near(self, k: int) -> int:
        """Return the largest budget up to a number of frames, or the smallest."""
        budgets: list[int] = self.config["budgets"]
        return max([budget for budget in budgets if budget <= k] or [min(budgets)])

    def scene_seed(self, wildcards: Any, *parts: object) -> int:
        """Return a seed from a scene's names and its use: adding a scene changes no other."""
        return name_seed(self.config["seed"], wildcards.dataset, wildcards.scene, *parts)

    def training_seed(self, wildcards: Any) -> int:
        """Return the seed of a labelled scene's search."""
        return name_seed(self.config["seed"], self.trained, wildcards.scene)

    def draw_seeds(self, wildcards: Any) -> list[int]:
        """Return the seeds of a scene's selections, one a draw."""
        return [self.scene_seed(wildcards, "select", n) for n in range(self.config["draws"])]

    def embedded_frames(self, dataset: str) -> int:
        """Return the number of frames of a dataset's embedded captures."""
        own, every = self.datasets.entries[dataset]["embedded"], self.config["embedded"]
        return int(own.get("frames", every["frames"]))

    def embedded_size(self, wildcards: Any) -> tuple[int, int]:
        """Return width and height of an embedded capture, of one to learn from those searched."""
        own, most = self.config["embedded"], 1.0
        width, height = own["width"], own["height"]
        if self.datasets.role_of(wildcards.dataset, wildcards.scene) in ("train", "validation"):
            used = [self.labeller, *self.reconstructors.values()]
            most = max(section["long_side"] for section in used) / max(width, height)
        scale = min(1.0, most)
        return round(scale * width), round(scale * height)


def named_reconstructors(sections: Section | Sequence[Section], where: str) -> dict[str, Section]:
    """Map the name of each reconstructor under the key `where`, its own by `as`, to its section;
    refuse two of one name."""
    found: dict[str, Section] = {}
    for section in [sections] if isinstance(sections, Mapping) else sections:
        name = section.get("as", section["name"])
        if name in found:
            raise Refusal(f"{where} has two named {name!r}", "`as` gives one of them another name")
        found[name] = without_name(section)
    return found


def without_name(section: Section) -> Section:
    """Return a section as reconstructors take it."""
    return {key: value for key, value in section.items() if key != "as"}


def described_reconstructor(name: str, section: Section) -> dict[str, Any]:
    """Return what a caption says of a reconstructor."""
    own = section["name"]
    return {
        "reconstructor": own if own == name else f"{name} ({own})",
        "long_side": section["long_side"],
    }


def shipped(policy: str) -> str:
    """Return the path of the scorer of a policy that comes with the package."""
    (path,) = (PACKAGE / "selectors" / "weights").glob(f"{policy}.*")
    return os.path.relpath(path)


def _as_shipped(config: Section, there: Mapping[str, Section]) -> dict[str, Any]:
    """Return the sections that differ without `train` scenes: the shipped scorers are measured."""
    if any(roles_of(entry).get("train") for entry in config["datasets"].values()):
        return {}
    training = config["training"]
    named = training["dataset"] in there
    dataset = training["dataset"] if named else next(iter(there), training["dataset"])
    weights = {policy: [shipped(policy)] for policy in TRAINED} | training["weights"]
    return {"training": {**training, "dataset": dataset, "weights": weights}}
