"""Tables and figures as data: a file says what its functions read, write and take.

`fsel.experiments.TABLES` lists them; `fsel.workflow.rules` makes rules of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fsel.workflow.experiment import Experiment
from fsel.workflow.inputs import table_files
from fsel.workflow.resources import Size

Values = Mapping[str, Any]
"""Name -> value, or a function of the wildcards that returns it."""

SMALL = Size()
FOLDER = "reconstructor"  # wildcard: the folder of a further one with its slash


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
