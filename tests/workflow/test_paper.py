"""The paper's tables: what can be made, of what, under which reconstructors, and why not."""

import re
from types import SimpleNamespace

import pytest
import yaml
from dry_runs import ROOT, experiment
from snakemake.utils import update_config

from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.functions import LISTED
from fsel.workflow.paper import Paper
from fsel.workflow.schema import Refusal

FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}


def test_a_file_of_roots_goes_over_the_paper_s_config():
    config, roots = (
        yaml.safe_load((ROOT / "config" / f"{name}.yaml").read_text())
        for name in ("paper", "paper_data")
    )
    update_config(config, roots)
    missing = Experiment.load(config, ROOT.joinpath).datasets.missing
    assert list(missing) == list(roots["datasets"]) == list(config["datasets"])
    assert all("(no folder /data/" in reason for reason in missing.values())


def test_captures_may_be_fetched_as_their_owners_lay_them_out():
    config, fetched = (
        yaml.safe_load((ROOT / "config" / f"{name}.yaml").read_text())
        for name in ("captures", "fetched_captures")
    )
    update_config(config, fetched)
    datasets = Experiment.load(config, ROOT.joinpath).datasets
    fox = SimpleNamespace(dataset="fox", scene="fox")
    assert datasets.raw_capture(fox) == "<results>/data/fox/fox"
    archive = SimpleNamespace(archive=datasets.archive_of(fox).removeprefix("<downloads>/"))
    assert datasets.archive(archive) == datasets.fetched(fox)


def test_what_is_measured_is_measured_by_the_scheme():
    """The others time a reconstruction, or draw its images."""
    folder = ROOT / "src" / "fsel" / "experiments"
    own = re.compile(r"reconstructor_of\(|RECONSTRUCTORS|Evaluator[.(]|checked_select")
    found = {path.stem for path in folder.rglob("*.py") if own.search(path.read_text())}
    assert found == {"footprint", "pictures"}


def test_every_table_is_a_rule_under_its_own_name_with_a_caption():
    rules = (ROOT / "workflow" / "rules").glob("*.smk")
    text = "".join(path.read_text() for path in rules)
    assert set(Paper(experiment()).needs()) <= set(LISTED)
    for name in LISTED:
        assert len(re.findall(rf"^use rule \w+ as {name} with:", text, re.M)) == 1, name
    for name in re.findall(r"\*\*shown\(\s*\"(\w+)\"", text):
        assert (ROOT / "workflow" / "report" / f"{name}.rst").is_file(), name


def test_the_paper_leaves_out_what_cannot_be_made_and_says_why(capsys):
    transfer = {"reconstructions": [{"name": "splats"}], "budgets": [7]}
    paths = Paper(experiment(transfer=transfer)).targets()
    assert "<tables>/handsign.tex" in paths
    assert "<figures>/pipeline.pdf" in paths
    assert "<figures>/qualitative_dl3dv.pdf" in paths
    assert not any("transfer" in path or "reconchoice" in path for path in paths)
    said = capsys.readouterr().err
    assert "paper: of 15 tables and figures" in said
    assert "  not made: transfer: transfer.budgets has [7], which are not among" in said
    assert "  not made: pose_sources: pose_sources.dataset is None" in said


def test_budgets_without_picks_are_refused():
    made = experiment(transfer={"reconstructions": [FIRST], "budgets": [5], "inputs": [5, 6]})
    with pytest.raises(Refusal, match=r"transfer\.inputs has \[6\]"):
        Paper(made).budgets("inputs")


def test_programs_that_a_table_names_must_be_there_when_it_is_made():
    wrong = SECOND | {"settings": {"steps": -1}}
    paper = Paper(experiment(transfer={"reconstructions": [wrong]}))
    for asked in (paper.targets, lambda: paper.programs("transfer")(None)):
        with pytest.raises(Refusal, match=r"transfer\.reconstructions, gaussians: .*steps"):
            asked()
    in_a_job = Paper(paper.experiment, asks=False)
    assert in_a_job.programs("transfer")(None) == []


def test_the_report_names_a_further_reconstructor():
    first, further = (SimpleNamespace(reconstructor=name) for name in ("", "g.2/"))
    labels = inputs.report_labels
    assert labels("Drawn", "table")(first) == {"table": "Drawn", "form": "LaTeX"}
    said = {"table": "Drawn, differences, g.2", "form": "numbers"}
    assert labels("Drawn", "differences")(further) == said
    assert labels("Drawn", "figures")(SimpleNamespace()) == {"figure": "Drawn"}
