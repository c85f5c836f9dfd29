"""The tables' specs: every one becomes a rule, under every reconstructor, or says why not."""

import re

import pytest
from dry_runs import ROOT, changed, dry_run, experiment, planned

from fsel.experiments import TABLES
from fsel.experiments.paper import compared
from fsel.experiments.paper.ablation import cases
from fsel.workflow.refusal import Refusal
from fsel.workflow.rules import Tables

FIRST = {"name": "splats", "long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}
# several reconstructors beside one another, none, or what is not about reconstruction
ONCE = {"transfer", "reconchoice", "pipeline_figure", "teaser", "qualitative"}
ONCE |= {"real_world", "selection_time", "speed_error", "economy", "stability"}


def test_evaluation_tables_take_every_reconstructor():
    made = experiment()
    for name, table in TABLES.items():
        path = next(iter(table.written(made).values()))
        path = path if isinstance(path, str) else path[0]
        assert ("{reconstructor}" in path) == (name not in ONCE), name


def test_what_is_measured_is_measured_by_the_scheme():
    """The others time a reconstruction, or draw its images."""
    folder = ROOT / "src" / "fsel" / "experiments"
    own = re.compile(r"reconstructor_of\(|RECONSTRUCTORS|Evaluator[.(]|checked_select")
    found = {path.stem for path in folder.rglob("*.py") if own.search(path.read_text())}
    assert found == {"bench", "footprint", "pictures"}


def test_a_table_has_the_name_of_its_rule():
    assert {name: table.rule for name, table in TABLES.items()} == {name: name for name in TABLES}


def test_a_further_reconstructor_measures_the_same_picks(tmp_path):
    config = changed(tmp_path, reconstruction=[FIRST, SECOND])
    names = ["candidate_pools", "ga_vs_learned", "feature_sweep", "scorer_arch"]
    targets = [f"results/smoke/tables/gaussians/{name}.tex" for name in names]
    rules = planned(dry_run(tmp_path, config, *targets))
    assert rules["evaluate_candidate_pools"] == rules["select_candidate_pools"] == 2
    assert rules["evaluate_searched"] == rules["search_oracle"] == 1


def test_the_paper_leaves_out_what_cannot_be_made():
    made = experiment(transfer={"reconstructions": [{"name": "splats"}], "budgets": [7]})
    paths, said = Tables(TABLES, made).possible()
    assert not any("transfer" in path or "reconchoice" in path for path in paths)
    assert any("transfer.budgets has [7], which are not among" in line for line in said)
    assert any(line.startswith("  not made: pose_sources: pose_sources.dataset") for line in said)


def test_budgets_without_picks_are_refused():
    made = experiment(transfer={"reconstructions": [FIRST], "budgets": [5], "inputs": [5, 6]})
    with pytest.raises(Refusal, match=r"transfer\.inputs has \[6\]"):
        compared.budgets(made, "inputs")


def test_cases_are_those_of_the_lists():
    made = experiment()
    features, scorers = (cases.cases(made, table) for table in (cases.FEATURES, cases.SCORERS))
    rows = (ROOT / "config" / "feature_sweep.csv").read_text().splitlines()[1:]
    assert list(features) == [row.split(",")[0] for row in rows]
    assert list(cases.scorer_labels(made)) == list(scorers)
    every = next(iter(features.values()))
    assert all(case["shown"] == every["shown"] for case in scorers.values())
    assert cases.scenes(made, cases.SCORERS) == [("dl3dv", "validation00")]
    elsewhere = experiment(trials={"scenes": {"scorer_arch": {"nowhere": "evaluation"}}})
    with pytest.raises(Refusal, match=r"trials\.scenes\.scorer_arch is .*, of which no scene"):
        cases.scenes(elsewhere, cases.SCORERS)
