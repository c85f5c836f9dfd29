"""The checked configuration as one object, and what of it every rule needs."""

from __future__ import annotations

import os
import re
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import yaml

from fsel.layouts import LAYOUTS
from fsel.metrics import REGISTERED
from fsel.reconstruct import RECONSTRUCTORS, needs_gpu
from fsel.workflow import checks, reconstructors
from fsel.workflow.datasets import Datasets, Section, kinds_of
from fsel.workflow.dependencies import Library
from fsel.workflow.resources import Resource, Size
from fsel.workflow.schema import complete, read_schema

PAGE = "config/README.md describes every key"
Scene = tuple[str, str]  # dataset, scene
Choice = Callable[[Any], Any]  # of the wildcards


@dataclass(frozen=True)
class Experiment:
    """A configuration with its defaults, whose parts fit together.

    Attributes:
        config: every key with its value; `datasets` are those that are there.
        folder: of the workflow, where `workflow`, `config` and `src` lie.
        datasets: where their captures are, and which are missing.
        reconstructors: name -> section of those that evaluate; the first labels too.
        labeller: section of the reconstructor that labels.
    """

    config: Mapping[str, Any]
    folder: Path
    datasets: Datasets
    reconstructors: Mapping[str, Section]
    labeller: Section

    @classmethod
    def load(cls, config: dict[str, Any], folder: Path) -> Experiment:
        """Complete a configuration and take it apart; what must be there is not looked at.

        Args:
            config: as it was read; defaults are put in.
            folder: of the workflow.

        Raises:
            Refusal: for an unknown key, or a value that is not allowed.
        """
        schemas = folder / "workflow" / "schemas"
        complete(config, read_schema(schemas / "config.schema.yaml"), PAGE)
        path = Path(config["sources"] or folder / "config" / "sources.yaml")
        sources = yaml.safe_load(path.read_text(encoding="utf-8"))
        complete(sources, read_schema(schemas / "sources.schema.yaml"), f"in {path}", str(path))
        for name, entry in config["datasets"].items():
            checks.check_kind(name, entry)
        datasets = Datasets.of(config["datasets"], sources)
        named = reconstructors.named(config["reconstruction"], "reconstruction")
        labeller = config["search"].get("reconstruction") or next(iter(named.values()))
        search = {key: value for key, value in config["search"].items() if key != "reconstruction"}
        own = {**config, "datasets": datasets.entries, "search": search}
        return cls(own, folder, datasets, named, reconstructors.without_name(labeller))

    def check(self) -> None:
        """Refuse parts that do not fit together, and what would only fail after hours of work."""
        trained = self.trained
        checks.check_datasets(self.datasets)
        checks.check_search(self.config["search"])
        checks.check_scenes(self.datasets, trained)
        needed = {role: self.frames_needed(role) for role in ("train", "evaluation", "object")}
        needed["validation"] = needed["train"]
        checks.check_frames(self.datasets, needed, self.config["embedded"]["frames"])

    # Scenes and problems

    @property
    def trained(self) -> str:
        """The dataset whose scenes are labelled."""
        return str(self.config["training"]["dataset"])

    def scenes(self, dataset: str, role: str) -> list[str]:
        """Names of a dataset's scenes with a role, in order."""
        return self.datasets.scenes(dataset, role)

    def with_role(self, role: str) -> list[Scene]:
        """The scenes of all datasets with a role."""
        return [(d, scene) for d in self.datasets.entries for scene in self.scenes(d, role)]

    @cached_property
    def evaluation_scenes(self) -> list[Scene]:
        """The scenes that the tables are of."""
        return self.with_role("evaluation")

    def problems(self, draws: int | None = None) -> list[str]:
        """dataset/scene/draw of every evaluation problem, or of those of the first draws."""
        count = self.config["draws"] if draws is None else draws
        return [f"{d}/{s}/draw{n}" for d, s in self.evaluation_scenes for n in range(count)]

    def searched_problems(self) -> list[str]:
        """Problems of the labelled dataset's evaluation scenes that are searched, if any."""
        draws = range(self.config["oracle"]["draws"])
        scenes = self.scenes(self.trained, "evaluation")
        return [f"{self.trained}/{scene}/draw{n}" for scene in scenes for n in draws]

    @cached_property
    def labelled(self) -> dict[str, str]:
        """Scene of the labelled dataset -> its role, `train` or `validation`."""
        roles = ("train", "validation")
        return {scene: role for role in roles for scene in self.scenes(self.trained, role)}

    @cached_property
    def practised(self) -> list[str]:
        """dataset/scene of the scenes that refinement practises on."""
        most = self.config["refinement"]["scenes"]
        scenes = self.scenes
        return [f"{d}/{s}" for d in self.datasets.entries for s in scenes(d, "train")[:most]]

    def frames_needed(self, role: str) -> int:
        """Least frames of a scene with a role."""
        return checks.frames_needed(self.config, role)

    def budget_near(self, k: int) -> int:
        """The largest budget up to a number of frames, or the smallest."""
        return checks.budget_near(self.config["budgets"], k)

    # Seeds

    def scene_seed(self, wildcards: Any, *parts: object) -> int:
        """A seed from the names of a scene and what it is for: adding a scene changes no other."""
        return self._seed(wildcards.dataset, wildcards.scene, *parts)

    def _seed(self, *parts: object) -> int:
        return zlib.crc32("/".join(map(str, [self.config["seed"], *parts])).encode())

    def training_seed(self, wildcards: Any) -> int:
        """The seed of a labelled scene's search."""
        return self._seed(self.trained, wildcards.scene)

    def draw_seeds(self, wildcards: Any) -> list[int]:
        """The seeds of a scene's selections, one a draw."""
        return [self.scene_seed(wildcards, "select", n) for n in range(self.config["draws"])]

    def generated(self, dataset: str, scene: str) -> dict[str, Any] | None:
        """What made an embedded capture, from which its exact depth is cast; None for others."""
        entry = self.datasets.entries[dataset]
        if kinds_of(entry) != ["embedded"]:
            return None
        return {
            "family": entry["embedded"]["family"],
            "seed": self.scene_seed(SimpleNamespace(dataset=dataset, scene=scene)),
            "recorded": self.config["embedded"]["frames"],
        }

    # Selectors, reconstructors and metrics

    @cached_property
    def seeds(self) -> range:
        """Seeds of the trained selectors."""
        return range(self.config["training"]["seeds"])

    def scorer_folder(self, policy: str) -> str:
        """Folder of the scorers of a policy that are trained here."""
        variant = policy.removeprefix("less_is_more").removeprefix("_")
        return f"<results>/selector/{variant}".rstrip("/")

    def weights(self, policy: str) -> list[str]:
        """Scorers of a trained policy: files that the configuration names, or one for each seed."""
        folder = self.scorer_folder(policy)
        named: list[str] = self.config["training"]["weights"].get(policy, [])
        return named or [f"{folder}/seed{seed}.safetensors" for seed in self.seeds]

    @cached_property
    def fsel(self) -> list[str]:
        """The rules `fsel`: refined here, or the one that comes with the package."""
        seeds = range(self.config["refinement"]["seeds"])
        refined = [f"<results>/selector/fsel/seed{seed}.json" for seed in seeds]
        return refined or [self._shipped("fsel.json")]

    @cached_property
    def scorers(self) -> list[str]:
        """The scorers of every learned and fixed selector."""
        trained = ("less_is_more", "less_is_more_no_appearance")
        weights = [path for policy in trained for path in self.weights(policy)]
        return [*weights, *self.fsel, self._shipped("fsel_rule.json")]

    def _shipped(self, name: str) -> str:
        return os.path.relpath(self.folder / "src" / "fsel" / "selector" / "weights" / name)

    @property
    def reconstruction(self) -> Section:
        """The first reconstructor's section."""
        return next(iter(self.reconstructors.values()))

    def reconstruction_of(self, wildcards: Any) -> Section:
        """The section of the wildcard `reconstructor`, which is empty for the first one."""
        name = wildcards.reconstructor.rstrip("/")
        return self.reconstructors[name] if name else self.reconstruction

    def searched_by(self, wildcards: Any) -> list[str]:
        """The searched problems, where the first reconstructor evaluates."""
        return [] if wildcards.reconstructor else self.searched_problems()

    @property
    def further(self) -> list[str]:
        """Folders of the reconstructors after the first, with a slash at their end."""
        return [f"{name}/" for name in list(self.reconstructors)[1:]]

    @cached_property
    def metrics(self) -> dict[str, Section]:
        """Name -> settings of the tables' metrics."""
        named = self.config["metrics"]
        return {name: self.config["lpips"] if name == "lpips" else {} for name in named}

    @cached_property
    def fitness(self) -> dict[str, Section]:
        """Name -> settings of the searches' metrics: others in the tables change no label."""
        perceptual = "lpips" if "lpips" in self.metrics else "gmsd"
        return {name: self.metrics.get(name, {}) for name in ("psnr", "ssim", perceptual)}

    @property
    def folders(self) -> str:
        """Pattern of the wildcard `reconstructor`."""
        return f"(?:{'|'.join(['', *map(re.escape, self.further)])})"

    def resources(
        self, size: Size, reconstruction: Section | Choice | None = None
    ) -> dict[str, Resource]:
        """Resources of a rule: memory, minutes, and a GPU where its reconstructor needs one.

        Args:
            size: of its jobs.
            reconstruction: the section of its reconstructor, or a function of the wildcards that
                returns it; None for a rule that does not reconstruct.
        """
        own = [s["long_side"] for s in self.reconstructors.values() if s["name"] != "external"]
        found = size.resources(max(own, default=0))
        if reconstruction is not None:
            choose = _choice(reconstruction)
            found["gpu"] = lambda wildcards: int(needs_gpu(choose(wildcards)))
        return found

    def library(
        self, module: str, reconstruction: Section | Choice | None = None
    ) -> list[str] | Choice:
        """Files of the library that a rule depends on, or a function of the wildcards.

        Args:
            module: the function's; a name without a dot is a stage.
            reconstruction: see `resources`; without it, the first reconstructor's.
        """
        name = module if "." in module else f"fsel.stages.{module}"
        if callable(reconstruction):
            choose = reconstruction
            return lambda wildcards: self._needed(name, choose(wildcards)["name"])
        return self._needed(name, (reconstruction or self.reconstruction)["name"])

    def _needed(self, module: str, reconstructor: str) -> list[str]:
        layouts = {entry["layout"] for entry in self.datasets.entries.values()}
        used = {reconstructor, "psnr", "ssim", "gmsd", *self.metrics, *layouts}
        homes = RECONSTRUCTORS.homes | REGISTERED.homes
        if "auto" not in layouts:
            homes |= LAYOUTS.homes
        unused = [home for name, home in homes.items() if name not in used]
        return self._library.needed(module, unused)

    @cached_property
    def _library(self) -> Library:
        # what a rule hands over is compared as its inputs and params
        folder = Path(os.path.relpath(self.folder / "src" / "fsel"))
        return Library(folder, Path(".snakemake", "library.json"), aside="fsel.workflow")

    def ingest_minutes(self, wildcards: Any, attempt: int) -> int:
        """Minutes of reading a capture; COLMAP takes longer."""
        poses = self.datasets.entries[wildcards.dataset]["poses"]
        return attempt * (240 if poses == "colmap" else 30)

    # What tables print

    def labels(self, names: Iterable[str] | None = None) -> dict[str, str]:
        """Name -> printed label of the datasets in the tables, or of some."""
        entries = self.datasets.entries
        chosen = [n for n in entries if self.scenes(n, "evaluation")] if names is None else names
        return {name: entries[name]["label"] for name in chosen}

    def facts(self, names: Sequence[str] | None = None, reconstructor: str = "") -> dict[str, Any]:
        """What a caption tells of the captures and the settings.

        Args:
            names: datasets; those in the tables by default.
            reconstructor: name of the one that made the table, with or without a slash; the first
                by default.
        """
        name = reconstructor.rstrip("/") or next(iter(self.reconstructors))
        embedded: list[str] = []
        real: list[str] = []
        for dataset, label in self.labels(names).items():
            generated = kinds_of(self.datasets.entries[dataset]) == ["embedded"]
            (embedded if generated else real).append(label)
        return {
            "embedded": embedded,
            "real": real,
            "missing": list(self.datasets.labels_missing),
            **reconstructors.described(name, self.reconstructors[name]),
            "descriptor": self.config["appearance"]["kind"],
            "search_k": self.config["search"]["k"],
            "draws": self.config["draws"],
            "oracle_draws": self.config["oracle"]["draws"],
            "places": self.places(),
            "oracle_dataset": self.datasets.entries[self.trained]["label"],
        }

    def facts_of(self, wildcards: Any) -> dict[str, Any]:
        """Facts of the tables' datasets and the reconstructor in the wildcards."""
        return self.facts(reconstructor=wildcards.reconstructor)

    def places(self) -> dict[str, str]:
        """dataset/scene -> place of evaluation scenes that may share one with another."""
        found = {}
        for d, s in self.evaluation_scenes:
            given = self.datasets.entries[d].get("places", {})
            shared = f"{given}/{s}" if isinstance(given, str) else given.get(s)
            if shared is not None:
                found[f"{d}/{s}"] = shared
        return found


def _choice(reconstruction: Section | Choice) -> Choice:
    return reconstruction if callable(reconstruction) else lambda wildcards: reconstruction
