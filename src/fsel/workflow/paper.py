"""What of the paper a configuration can make, and the reconstructors that its tables name."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fsel.captures.colmap.estimator import source_of
from fsel.workflow import inputs, requirements, scenes
from fsel.workflow.datasets import Section
from fsel.workflow.experiment import Choice, Experiment
from fsel.workflow.schema import MissingProgram, Refusal
from fsel.workflow.settings import (
    PAGE,
    described_reconstructor,
    named_reconstructors,
    without_name,
)

TRANSFER, CHOICE, PICTURES = "transfer", "reconchoice", "pictures"  # sections with reconstructors
STAND_INS = "config/stand_ins.yaml"


@dataclass(frozen=True)
class Paper:
    """The paper's tables and figures in one configuration."""

    experiment: Experiment
    asks: bool = True  # whether programs must be here; the jobs of a run need not ask again

    def targets(self) -> list[str]:
        """List the paths of the tables and figures that can be made; print what cannot, and why;
        refuse programs that are named and not here."""
        if lines := self.missing_programs():
            raise Refusal("\n".join(["tables of the paper need what is missing:", *lines]), PAGE)
        made, said = self.possible()
        if said:
            count = len(self.needs())
            head = f"paper: of {count} tables and figures, these cannot be made, or only in part"
            print("\n".join([f"{head}:", *said]), file=sys.stderr)
        return made

    def possible(self) -> tuple[list[str], list[str]]:
        """Return the paths that can be made here, and lines that say what cannot."""
        made: list[str] = []
        said = [f"  left out: {reason}" for reason in self.experiment.datasets.missing.values()]
        for name, needs in self.needs().items():
            try:
                for need in needs:
                    need()
            except Refusal as refusal:
                said.append(f"  not made: {name}: {refusal.reason.splitlines()[0]}")
            else:
                made += self._paths(name)
        return made, said

    def needs(self) -> dict[str, Sequence[Callable[[], object]]]:
        """Map each table or figure to functions that refuse a configuration without its inputs."""
        made = self.experiment
        labels = partial(scenes.with_labels, made)
        return {
            "handsign": (),
            "seedvar": (),
            "ga_vs_learned": (partial(scenes.held_out_problems, made),),
            "time_quality": (partial(scenes.held_out, made), labels),
            "crosscapture": (partial(scenes.rooms, made),),
            "objectcentric": (partial(scenes.of_objects, made),),
            "feature_sweep": (partial(scenes.tried, made, "feature_sweep"), labels),
            "scorer_arch": (partial(scenes.tried, made, "scorer_arch"), labels),
            "pose_sources": (partial(scenes.posed_twice, made),),
            TRANSFER: (partial(self.evaluations, TRANSFER, []), partial(self.budgets, "budgets")),
            CHOICE: (partial(self.evaluations, CHOICE, []), partial(self.budgets, "inputs")),
            "pipeline_figure": (labels,),
            "teaser": (),
            "qualitative": (),
            "real_world": (partial(scenes.rooms, made),),
        }

    def _paths(self, name: str) -> list[str]:
        if name == "qualitative":
            return [f"<figures>/qualitative_{d}.pdf" for d in self.experiment.labels()]
        if name in ("pipeline_figure", "teaser", "real_world"):
            return [f"<figures>/{name.removesuffix('_figure')}.pdf"]
        return [f"<tables>/{name}.tex", f"<tables>/{name}.html"]

    def missing_programs(self) -> list[str]:
        """List what the reconstructors of the tables need and is not here."""
        lines: list[str] = []
        for section in (TRANSFER, CHOICE, PICTURES) if self.asks else ():
            try:
                self._check_programs(section)
            except MissingProgram as missing:
                lines += missing.reason.splitlines()
        return list(dict.fromkeys(lines))

    def _check_programs(self, section: str) -> None:
        if section == PICTURES:
            named, where = {self.pictured["name"]: self.pictured}, section
        else:
            checked = self.experiment.reconstructors.values()
            compared = self.compared(section).items()
            named = {name: part for name, part in compared if part not in checked}
            where = f"{section}.reconstructions"
        requirements.check_reconstructors(named, where)

    def library(self, rule: str, section: str) -> str | Choice:
        """Return a digest of what a rule depends on, see `Experiment.library`."""
        return self.experiment.library(rule, self.pictured if section == PICTURES else None)

    def programs(self, section: str) -> Choice:
        """Return an input function that names no file and refuses missing programs."""

        def checked(wildcards: Any) -> list[str]:
            if self.asks:
                self._check_programs(section)
            return []

        return checked

    def check(self, configfiles: Sequence[str]) -> None:
        """Refuse a run of some configuration files that needs what is not here, on one page; with
        `allow_missing`, datasets but the labelled one may be missing."""
        experiment, datasets = self.experiment, self.experiment.datasets
        others = requirements.missing_programs(experiment)
        requirements.check_scorers(experiment)
        needed = experiment.trained in datasets.missing or not datasets.entries
        refused = datasets.missing and (needed or not experiment.config["allow_missing"])
        if not others and not refused:
            return
        others += self.missing_programs()
        lines = [f"{len(others)} of what is named is not here:", *(f"  {line}" for line in others)]
        lines = [*lines, *self._without(configfiles)] if others else []
        hint = "get each as it says, docs/reconstructors.md has the licences"
        if refused:
            count = len(datasets.missing) + len(datasets.entries)
            head = f"no folders (from {Path.cwd()}) for {len(datasets.missing)} of {count} datasets"
            lines = [f"{head}:", *(f"  {reason}" for reason in datasets.missing.values()), *lines]
            hint = (
                "put each dataset there, correct the path, or leave its entry out; "
                "`allow_missing: true` makes what can be made without, and captions name what is "
                "missing"
            )
        raise Refusal("\n".join(lines), hint)

    def _without(self, configfiles: Sequence[str]) -> list[str]:
        """Describe how a run goes without what is not here, and what it makes then."""
        experiment = self.experiment
        files = [*map(Path, configfiles), Path(experiment.locate(STAND_INS))]
        given = " ".join(os.path.relpath(path) for path in files)
        allowed = " --config allow_missing=True" if experiment.datasets.missing else ""
        lines = [
            "without: `splats`, GMSD and `lab_hog` in the place of what is missing, by",
            f"  snakemake paper --cores 2 --configfile {given}{allowed}",
        ]
        if experiment.trained in experiment.datasets.missing:
            return [*lines, "  once the dataset of training.dataset is there"]
        made, left_out = self.possible()
        names = ", ".join(path.rsplit("/")[-1] for path in made if not path.endswith(".html"))
        return [*lines, f"  which makes {names}", *left_out]

    def compared(self, table: str) -> dict[str, Section]:
        """Map each reconstructor of a table to its section; `reconchoice` has those of `transfer`
        unless it names its own."""
        own = self.experiment.config[table]["reconstructions"]
        given = self.experiment.config[TRANSFER]["reconstructions"] if own is None else own
        return named_reconstructors(given, f"{table}.reconstructions")

    def reconstruction(self, table: str) -> Choice:
        """Choose the section of the wildcard `compared` among the reconstructors of a table."""
        return lambda wildcards: self.compared(table)[wildcards.compared]

    def budgets(self, key: str) -> list[int]:
        """Return `budgets` or `inputs` of the section `transfer`; refuse those without picks."""
        chosen: list[int] = self.experiment.config[TRANSFER][key]
        swept = self.experiment.config["budgets"]
        if missing := [k for k in chosen if k not in swept]:
            raise Refusal(
                f"transfer.{key} has {missing}, which are not among budgets {swept}",
                "nothing is selected for these tables; picks of the sweep are taken",
            )
        return chosen

    @property
    def pass_budgets(self) -> list[int]:
        """Budgets near 30 and 40, the columns of `crosscapture`."""
        return sorted({self.experiment.budget_near(30), self.experiment.budget_near(40)})

    @property
    def draws(self) -> range:
        """Draws that every reconstructor of `transfer` measures."""
        config = self.experiment.config
        return range(min(config["draws"], config[TRANSFER]["draws"]))

    def evaluations(self, table: str, draws: Sequence[int]) -> list[str]:
        """List the evaluations of the held-out scenes by each reconstructor of a table."""
        held_out = scenes.held_out(self.experiment)
        files = [f"{name}/{table}.parquet" for name in self.compared(table)]
        return [path for file in files for path in inputs.of_scenes(held_out, file, draws)]

    def described(self, table: str) -> dict[str, dict[str, Any]]:
        """Map each reconstructor of a table to what a caption says of it."""
        sections = self.compared(table).items()
        return {name: described_reconstructor(name, section) for name, section in sections}

    def pose_labels(self) -> list[str]:
        """Name the two sources of poses as `pose_sources` prints them."""
        (dataset,) = scenes.datasets_of(scenes.posed_twice(self.experiment))
        (label,) = self.experiment.labels([dataset]).values()
        entry = self.experiment.datasets.entries[dataset]
        other = self.experiment.config["pose_sources"]
        first = source_of(entry["poses"], entry.get("model", ""))
        return [f"{label}, {first}", other["label"] or source_of(other["poses"], other["model"])]

    def searched_scenes(self) -> dict[int, str]:
        """Map the narrowest, the middle and the widest coverage level to its first scene."""
        scenes.with_labels(self.experiment)  # refuses a configuration without any
        first: dict[int, str] = {}
        for scene, levels in self.experiment.coverages.items():
            first |= {level: scene for level in levels if level not in first}
        levels = sorted(first)
        return {c: first[c] for c in (levels[0], levels[len(levels) // 2], levels[-1])}

    def searched(self, wildcards: Any) -> inputs.Paths:
        """Return the files that `pipeline_figure` draws, see `searched_scenes`."""
        drawn, dataset = self.searched_scenes(), self.experiment.trained
        return {
            **inputs.captures([f"{dataset}/{s}" for s in drawn.values()]),
            "splits": [f"<results>/labels/{scene}/splits.parquet" for scene in drawn.values()],
            "labels": [inputs.LABELS.format(scene=s, coverage=c) for c, s in drawn.items()],
            "trajectories": "<results>/trajectories.parquet",
        }

    def pictured_scene(self, dataset: str) -> inputs.Paths:
        """Return the files of the first evaluation scene of a dataset, whose views are drawn."""
        scene = self.experiment.scenes(dataset, "evaluation")[0]
        folder, draws = f"<results>/{dataset}/{scene}", range(self.experiment.config["draws"])
        return {
            **inputs.capture(folder=f"{folder}/pictures"),
            "split": f"{folder}/draw0/split.parquet",
            "selections": f"{folder}/draw0/selections.parquet",
            "evaluations": [f"{folder}/draw{n}/evaluation.parquet" for n in draws],
        }

    def pictured_room(self, wildcards: Any) -> inputs.Paths:
        """Return the files of the first place filmed in several passes, whose views are drawn."""
        folder = f"<results>/{inputs.joined(scenes.rooms(self.experiment))[0]}"
        return {
            **inputs.capture(folder=f"{folder}/pictures"),
            "selected_from": f"{folder}/frames.parquet",
            "picks": f"{folder}/crosscapture_picks.parquet",
            "evaluation": f"{folder}/crosscapture.parquet",
        }

    @property
    def pictured(self) -> Section:
        """Reconstructor of the pictures."""
        return without_name(self.experiment.config[PICTURES])

    def picture_facts(self, dataset: str) -> dict[str, Any]:
        """Return what the line under a figure of views says of a dataset and the reconstructor."""
        own = self.pictured
        return self.experiment.facts([dataset]) | described_reconstructor(own["name"], own)

    def picture_size(self) -> dict[str, int]:
        """Return the width and height of embedded captures that are rendered again for pictures."""
        size = {side: self.experiment.config["embedded"][side] for side in ("width", "height")}
        scale = self.pictured["long_side"] / max(size.values())
        return {side: round(scale * pixels) for side, pixels in size.items()}
