"""Tables and figures as data: a file says what its functions read, write and take.

`fsel.experiments.TABLES` lists them; workflow/rules/tables.smk declares the rules.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from types import SimpleNamespace
from typing import Any

from fsel.utils.registry import Registry
from fsel.workflow.experiment import Experiment, gpus_of
from fsel.workflow.inputs import table_files
from fsel.workflow.refusal import MissingProgram, Refusal, refuse
from fsel.workflow.resources import Size
from fsel.workflow.settings import PAGE

Values = Mapping[str, Any]
"""Name -> value, or a function of the wildcards that returns it."""

SMALL = Size()
FOLDER = "reconstructor"  # wildcard: the folder of a further one with its slash
WILDCARD = re.compile(r"\{(\w+)\}")


def nothing(experiment: Experiment) -> Values:
    """No inputs, or no params."""
    return {}


@dataclass(frozen=True)
class Job:
    """A rule: a function of the library, and where its arguments come from.

    Attributes:
        function: what is run; the rule has its name. Its parameters are the inputs, outputs and
            params of their names (see `fsel.workflow.job.arguments`).
        outputs: name -> path, or paths; or experiment -> such. Wildcards in braces;
            `{reconstructor}` is the folder of a reconstructor with its slash, and empty for the
            first. One that is named `folder` is a folder.
        message: what is printed when it starts.
        inputs: experiment -> name -> path, paths, or a function of the wildcards that returns them.
            It may refuse an experiment that lacks what the job needs.
        params: experiment -> name -> value, or a function of the wildcards. One that is named
            `reconstruction` decides whether the job needs a GPU, and which sources it depends on;
            `poses` decides the first.
        size: of the job; or experiment -> such.
        name: of the rule, where it is not the function's.
        home: `module:function`, where the function is of an object of the module: `module:A.run`.
    """

    function: Callable[..., None]
    outputs: Values | Callable[[Experiment], Values] = field(default_factory=dict)
    message: str = ""
    inputs: Callable[[Experiment], Values] = nothing
    params: Callable[[Experiment], Values] = nothing
    size: Size | Callable[[Experiment], Size] = SMALL
    name: str = ""
    home: str = ""

    @property
    def rule(self) -> str:
        """Name of the rule."""
        return self.name or self.function.__name__

    @property
    def place(self) -> str:
        """`module:function`."""
        return self.home or f"{self.function.__module__}:{self.function.__name__}"

    def written(self, experiment: Experiment) -> Values:
        """The outputs in an experiment."""
        return self.outputs(experiment) if callable(self.outputs) else self.outputs


@dataclass(frozen=True)
class Table(Job):
    """The rule that writes a table or draws a figure, and the rules of its file that come before.

    Outputs named `table`, `numbers`, `differences` and `figures` are shown in the report. Without
    outputs, they are a table of every reconstructor and its numbers; without a message, it is made
    of the title.

    Attributes:
        title: printed in the report.
        caption: a paragraph of the report, in reStructuredText.
        category: a heading of the report.
        jobs: the rules that its inputs come from, besides those of the stages. One that several
            tables have is declared once.
        needs: what is asked of the experiment besides inputs and params, when it is found out
            whether the table can be made; each may refuse it.
        programs: refuses an experiment whose programs for the table are not here; it is asked
            before any job where the table is asked for.
        targets: experiment -> the paths that stand for it in `paper`; its first output by default.
    """

    title: str = ""
    caption: str = ""
    category: str = "Tables"
    jobs: Sequence[Job] = ()
    needs: Sequence[Callable[[Experiment], object]] = ()
    programs: Callable[[Experiment], object] = nothing
    targets: Callable[[Experiment], list[str]] | None = None

    def __post_init__(self) -> None:
        name = f"{{{FOLDER}}}{self.function.__name__}"
        object.__setattr__(self, "outputs", self.outputs or table_files(name))
        object.__setattr__(self, "message", self.message or f"Making: {self.title}")

    def paths(self, experiment: Experiment) -> list[str]:
        """The paths that stand for the table."""
        if self.targets is not None:
            return self.targets(experiment)
        return [_emptied(_first(self.written(experiment)))]


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
            if self.experiment.further:
                further = self._rule(replace(job, name=f"{job.rule}_further"))
                pattern = "|".join(map(re.escape, self.experiment.further))
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
            names = [name for name in SHOWN if name in outputs]
            shown = {
                n: {"category": job.category, "labels": report_labels(job.title, n)} for n in names
            }
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
                made += table.paths(self.experiment)
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
