"""Tables as data become rules."""

from types import SimpleNamespace

import pytest
from dry_runs import experiment

from fsel.experiments import TABLES
from fsel.workflow import inputs
from fsel.workflow.refusal import MissingProgram, Refusal, refuse
from fsel.workflow.resources import Size
from fsel.workflow.rules import Tables, report_labels
from fsel.workflow.tables import Job, Table

WILDCARDS = SimpleNamespace(dataset="d", scene="s", reconstructor="")


class Wildcards(SimpleNamespace):
    """As Snakemake's: attributes that can be listed."""

    def items(self):
        return self.__dict__.items()


def measure(folder, out, *, reconstruction): ...


def draw(files, table, numbers): ...


def refused(made):
    refuse("no scenes of this kind", "add some")


MEASURED = Job(
    measure,
    outputs={"out": f"{inputs.SCENE}/{{reconstructor}}out.parquet"},
    message="Measuring",
    inputs=lambda made: inputs.capture(),
    params=lambda made: {"reconstruction": made.reconstruction_of},
    size=Size(4000, 30, "reconstruction"),
)
DRAWN = Table(
    draw,
    outputs=inputs.table_files("{reconstructor}drawn"),
    message="Drawing",
    inputs=lambda made: {"files": inputs.of_scenes(made.evaluation_scenes, "out.parquet")},
    category="Paper",
    title="Drawn",
    caption="What was drawn.",
    jobs=[MEASURED],
)


@pytest.fixture
def made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(type(experiment()), "library", lambda self, *given: given)
    return experiment()


def test_a_table_and_its_jobs_are_rules(made):
    first, second = Tables({"drawn": DRAWN}, made).rules()
    assert second.outputs == {"table": "<tables>/drawn.tex", "numbers": "<tables>/drawn.csv"}
    assert (first.name, second.name) == ("measure", "draw")
    assert first.log == "<results>/logs/{reconstructor}measure/{dataset}/{scene}.log"
    assert second.benchmark == "<results>/benchmarks/draw.jsonl"
    assert first.params["job"] == f"{__name__}:measure"
    assert first.inputs["lib"] == (__name__, made.reconstruction_of, ())
    assert second.inputs["lib"] == (__name__, None, ())
    assert first.resources["gpu"](WILDCARDS) == 0
    assert "gpu" not in second.resources
    assert first.shown == {}
    assert set(second.shown) == {"table", "numbers"}
    assert second.shown["table"]["category"] == "Paper"


def test_further_reconstructors_have_a_rule_of_their_own(made):
    sections = [{"name": "splats"}, {"name": "splats", "as": "s.2"}]
    made = experiment(reconstruction=sections)  # its `library` is replaced by `made`
    table = Table(
        draw,
        outputs=inputs.table_files("{reconstructor}drawn"),
        message="",
        inputs=lambda made: {"files": lambda wildcards: [f"{wildcards.reconstructor}a"]},
        params=lambda made: {"facts": made.facts_of, "numbers": ["{reconstructor}b", 3]},
    )
    tables = Tables({"draw": table}, made)
    first, further = tables.rules()
    assert (first.name, further.name) == ("draw", "draw_further")
    none, second = Wildcards(), Wildcards(reconstructor="s.2/")
    assert first.inputs["files"](none) == ["a"]
    assert first.params["facts"](none)["reconstructor"] == "splats"
    assert first.params["numbers"] == ["b", 3]
    assert first.constraints == {}
    assert further.inputs["files"](second) == ["s.2/a"]
    assert further.outputs["table"] == "<tables>/{reconstructor}drawn.tex"
    assert further.params["facts"](second)["reconstructor"] == "s.2 (splats)"
    assert further.constraints == {"reconstructor": r"s\.2/"}
    assert further.log == "<results>/logs/{reconstructor}draw_further.log"
    assert set(tables.captions()) == {"draw", "draw_further"}


def test_a_job_of_several_tables_is_one_rule(made):
    other = Table(refused, outputs={"table": "t"}, message="", jobs=[MEASURED])
    rules = Tables({"drawn": DRAWN, "other": other}, made).rules()
    assert [rule.name for rule in rules] == ["measure", "draw", "refused"]


@pytest.mark.parametrize("part", ["inputs", "params"])
def test_a_table_that_cannot_be_made_refuses_when_asked_for(made, part):
    table = Table(draw, outputs={"table": "<tables>/a.tex"}, message="", **{part: refused})
    (rule,) = Tables({"a": table}, made).rules()
    with pytest.raises(Refusal, match="no scenes of this kind"):
        rule.inputs["refused"](WILDCARDS)


def test_what_of_the_paper_can_be_made_and_why_not(made, capsys):
    def paper(**more):
        return Table(
            draw, outputs={"table": "<tables>/a.tex"}, message="", category="Paper", **more
        )

    tables = {
        "drawn": DRAWN,
        "lacking": paper(inputs=refused),
        "needing": paper(needs=[refused]),
        "several": paper(targets=lambda made: ["<figures>/1.pdf", "<figures>/2.pdf"]),
        "study": Table(draw, outputs={"table": "<tables>/b.tex"}, message="", category="Speed"),
    }
    found = Tables(tables, made).of_the_paper()
    assert found == ["<tables>/drawn.tex", "<figures>/1.pdf", "<figures>/2.pdf"]
    said = capsys.readouterr().err
    assert "  not made: lacking: no scenes of this kind\n" in said
    assert "  not made: needing: no scenes of this kind\n" in said


def test_the_report_names_a_further_reconstructor():
    further = SimpleNamespace(reconstructor="g.2/")
    assert report_labels("Drawn", "table")(WILDCARDS) == {"table": "Drawn", "form": "LaTeX"}
    assert report_labels("Drawn", "differences")(further) == {
        "table": "Drawn, differences, g.2",
        "form": "numbers",
    }
    assert report_labels("Drawn", "figures")(SimpleNamespace()) == {"figure": "Drawn"}


def test_every_table_of_the_registry_says_what_it_is():
    for name, table in TABLES.items():
        assert table.rule == name
        assert table.title, name
        assert table.caption, name
        assert table.message, name
        home = table.function.__module__
        assert home == TABLES.homes[name].partition(":")[0]
        assert home.split(".")[2] in ("paper", "studies")


def test_programs_that_a_table_names_are_asked_for_with_it(made):
    lines = ["transfer, mine: no program 'mine'"]

    def lacking(made):
        raise MissingProgram(lines, "get it")

    table = Table(
        draw, outputs={"table": "<tables>/a.tex"}, message="", category="Paper", programs=lacking
    )
    tables = Tables({"a": table, "b": table}, made)
    with pytest.raises(Refusal, match="no program 'mine'\nHint: get it"):
        tables.rules()[0].inputs["lib"](WILDCARDS)
    with pytest.raises(Refusal, match="what is not here:\ntransfer, mine: no program 'mine'\nHint"):
        tables.of_the_paper()
    in_a_job = Tables({"a": table}, made, asks=False)
    assert in_a_job.rules()[0].inputs["lib"] == (__name__, None, ())
    assert in_a_job.of_the_paper() == ["<tables>/a.tex"]
