"""The rules of the tables, as Snakemake takes them, and what of the paper can be made."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import SimpleNamespace
from typing import Any

from fsel.core.registry import Registry
from fsel.workflow.experiment import Experiment, gpus_of
from fsel.workflow.refusal import MissingProgram, Refusal, refuse
from fsel.workflow.settings import PAGE
from fsel.workflow.tables import FOLDER, Job, Table, Values, nothing

WILDCARD = re.compile(r"\{(\w+)\}")


def report_labels(title: str, output: str) -> Callable[[Any], dict[str, str]]:
    """Input function: what the report prints beside an output of `SHOWN`.

    Args:
        title: of the table or figure; the name of a further reconstructor is added.
        output: its name.
    """
    kind = "figure" if output == "figures" else "table"
    form = {} if output == "figures" else {"form": "LaTeX" if output == "table" else "numbers"}
    differences = ", differences" if output == "differences" else ""

    def labels(wildcards: Any) -> dict[str, str]:
        folder = getattr(wildcards, "reconstructor", "").rstrip("/")
        return {kind: f"{title}{differences}" + (f", {folder}" if folder else ""), **form}

    return labels


PAPER = "Paper"  # category of the tables that `paper` makes
SHOWN = ("table", "numbers", "differences", "figures")


@dataclass(frozen=True)
class Rule:
    """A job of an experiment, as Snakemake takes it.

    Attributes:
        name, message: of the rule.
        inputs, params, resources: see `Job`; `params` say by `job` which function is run.
        outputs: name -> path or paths.
        log, benchmark: their paths.
        constraints: pattern of the wildcard `reconstructor` where it is not empty.
        shown: name of an output -> category and labels in the report.
    """

    name: str
    message: str
    inputs: Values
    outputs: Values
    params: Values
    resources: Values
    log: str
    benchmark: str
    constraints: Mapping[str, str]
    shown: Mapping[str, dict[str, Any]]


@dataclass(frozen=True)
class Tables:
    """The tables of an experiment.

    Attributes:
        entries: name -> table, those of the paper.
        experiment: the run's.
        asks: whether programs must be here; in the jobs of a run they were asked for.
    """

    entries: Mapping[str, Table]
    experiment: Experiment
    asks: bool = True

    def rules(self) -> list[Rule]:
        """The rules of all tables; those that several share once.

        A table of every reconstructor has two: that of the first one has no wildcard, so that its
        name can be asked for; that of the others has `_further` after its name.
        """
        jobs: dict[str, Job] = {}
        for table in self.entries.values():
            for job in (*table.jobs, table):
                jobs.setdefault(job.rule, job)
        rules = []
        for job in jobs.values():
            if set(WILDCARD.findall(_first(job.written(self.experiment)))) != {FOLDER}:
                rules.append(self._rule(job))
                continue
            rules.append(self._rule(_of_first(job)))
            if self.experiment.extra_reconstructors:
                further = self._rule(replace(job, name=f"{job.rule}_further"))
                pattern = "|".join(map(re.escape, self.experiment.extra_reconstructors))
                rules.append(replace(further, constraints={FOLDER: pattern}))
        return rules

    def _rule(self, job: Job) -> Rule:
        experiment = self.experiment
        outputs = job.written(experiment)
        try:
            inputs, params = job.inputs(experiment), job.params(experiment)
        except Refusal as refusal:
            inputs, params = {"refused": _raising(refusal)}, {}
        reconstruction = params.get("reconstruction")
        size = job.size(experiment) if callable(job.size) else job.size
        resources = experiment.resources(size, reconstruction)
        if poses := params.get("poses"):
            resources["gpu"] = lambda wildcards: gpus_of(poses)
        module = job.place.partition(":")[0]
        # the package lists all tables; one does without the others
        apart = self.entries.homes.values() if isinstance(self.entries, Registry) else ()
        library = experiment.library(module, reconstruction, apart)
        shown = {}
        if isinstance(job, Table):
            if self.asks and job.programs is not nothing:
                library = _asking(partial(job.programs, experiment), library)
            kinds = [kind for kind in SHOWN if kind in outputs]
            labels = {kind: report_labels(job.title, kind) for kind in kinds}
            shown = {n: {"category": job.category, "labels": each} for n, each in labels.items()}
        return Rule(
            job.rule,
            job.message,
            {**inputs, "lib": library},
            outputs,
            {**params, "job": job.place},
            resources,
            f"<results>/logs/{_place(job, outputs)}.log",
            f"<results>/benchmarks/{_place(job, outputs)}.jsonl",
            {},
            shown,
        )

    def captions(self) -> dict[str, str]:
        """Rule -> caption in the report."""
        captions = {table.rule: table.caption for table in self.entries.values()}
        return captions | {f"{name}_further": text for name, text in captions.items()}

    def of_the_paper(self) -> list[str]:
        """Paths of the paper's tables that can be made here; what cannot, and why, is printed.

        Raises:
            Refusal: for programs that tables name and that are not here.
        """
        if lines := self.missing_programs():
            refuse("\n".join(["tables of the paper name what is not here:", *lines]), PAGE)
        made, said = self.possible()
        if said:
            count = sum(table.category == PAPER for table in self.entries.values())
            head = f"paper: of {count} tables and figures, these cannot be made or are of less:"
            print("\n".join([head, *said]), file=sys.stderr)
        return made

    def missing_programs(self) -> list[str]:
        """List what the reconstructors of the paper's tables need and is not here."""
        lines: list[str] = []
        for table in self.entries.values():
            try:
                if self.asks and table.category == PAPER:
                    table.programs(self.experiment)
            except MissingProgram as missing:
                lines += missing.lines
        return list(dict.fromkeys(lines))

    def possible(self) -> tuple[list[str], list[str]]:
        """Paths of the paper's tables that stand-ins can make here, and what cannot be made."""
        made: list[str] = []
        reasons = self.experiment.datasets.missing.values()
        said = [f"  left out: {reason}" for reason in reasons]
        for name, table in self.entries.items():
            if table.category != PAPER:
                continue
            try:
                for need in (table.inputs, table.params, *table.needs):
                    need(self.experiment)
                first = [_emptied(_first(table.written(self.experiment)))]
                made += table.targets(self.experiment) if table.targets else first
            except Refusal as refusal:
                reason = str(refusal).removeprefix("config: ").splitlines()[0]
                said.append(f"  not made: {name}: {reason}")
        return made, said


def _asking(ask: Callable[[], object], files: Any) -> Callable[[Any], Any]:
    """The input function of some files, or of what a function returns, that asks first."""

    def asked(wildcards: Any) -> Any:
        ask()
        return files(wildcards) if callable(files) else files

    return asked


def _place(job: Job, outputs: Values) -> str:
    """The rule's name in the reconstructor's folder, and the other wildcards below it."""
    wildcards = dict.fromkeys(WILDCARD.findall(_first(outputs)))
    folder = f"{{{FOLDER}}}" if FOLDER in wildcards else ""
    others = [f"{{{name}}}" for name in wildcards if name != FOLDER]
    return "/".join([f"{folder}{job.rule}", *others])


def _of_first(job: Job) -> Job:
    """A job of the first reconstructor alone: the wildcard of its folder is empty."""
    return replace(
        job,
        outputs=lambda experiment: _emptied(job.written(experiment)),
        inputs=lambda experiment: _emptied(job.inputs(experiment)),
        params=lambda experiment: _emptied(job.params(experiment)),
    )


def _emptied(value: Any) -> Any:
    if isinstance(value, str):
        return value.replace(f"{{{FOLDER}}}", "")
    if isinstance(value, Mapping):
        return {key: _emptied(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_emptied(part) for part in value)
    if callable(value):
        return lambda wildcards: _emptied(
            value(SimpleNamespace(**dict(wildcards.items()), **{FOLDER: ""}))
        )
    return value


def _first(outputs: Values) -> str:
    path = next(iter(outputs.values()))
    return str(path if isinstance(path, str) else path[0])


def _raising(refusal: Refusal) -> Callable[[Any], list[str]]:
    def refused(wildcards: Any) -> list[str]:
        raise refusal

    return refused
