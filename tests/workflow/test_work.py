"""What jobs ask a cluster for, from what a reconstructor says it costs."""

import pytest
from dry_runs import SMOKE, changed, dry_run, experiment, planned

from fsel.workflow import work
from fsel.workflow.refusal import Refusal
from fsel.workflow.resources import Size

COST = {"load": 15, "fit": 2, "render": 0.1}
SERVED = {"name": "external", "settings": {"serve": ["true"]}, "cost": COST}
STARTED = {"name": "external", "settings": {"render": ["true"]}, "cost": COST}


def resources(made, kind=work.label, **taken):
    size = Size(4000, 120, "reconstruction")
    found = made.resources(size, made.labeller, kind)
    return {key: found[key](None, input=[], attempt=1) for key in ("runtime", "mem_mb")}


def test_the_genetic_search_of_the_paper_evaluates_610_subsets():
    search = {"labeller": "genetic", "population": 40, "generations": 15, "elites": 2}
    assert work.searched(search) == 40 + 15 * 38
    assert work.searched({"labeller": "swap", "evaluations": 450}) == 450


@pytest.mark.parametrize(("section", "loads"), [(SERVED, 1), (STARTED, 7)])
def test_a_program_that_does_not_serve_is_loaded_for_every_subset(section, loads):
    job = work.Work(subsets=7, views=4)
    seconds = loads * 15 + 7 * (2 + 4 * 0.1)
    assert job.seconds(section, COST) == pytest.approx(seconds)
    assert job.minutes(section, COST) == -(-seconds * 1.5 // 60) + 10


def test_minutes_and_memory_follow_the_cost_and_nothing_else_does():
    stated = {key: value for key, value in SERVED.items() if key != "cost"}
    usual, made = experiment(reconstruction=stated), experiment(reconstruction=SERVED)
    assert made.reconstruction == usual.reconstruction  # no job runs again for it
    job = work.label(made.config)
    assert resources(made)["runtime"] == job.minutes(SERVED, COST)
    assert resources(usual) == {"runtime": 120, "mem_mb": 4000}
    assert resources(made)["mem_mb"] == 4000
    larger = experiment(reconstruction={**SERVED, "cost": COST | {"memory": 20_000}})
    assert resources(larger)["mem_mb"] == 20_000
    assert made.resources(Size(1, 1, "capture"))["runtime"](None, input=[], attempt=2) == 2


def test_labels_in_several_jobs_take_a_share_each(tmp_path):
    one, three = (experiment(reconstruction=SERVED, label_jobs=n) for n in (1, 3))
    whole = work.label(one.config).subsets
    assert whole == len(SMOKE["coverages"]) * work.searched(one.config["search"])
    assert work.label(three.config).subsets == -(-whole // 3)
    jobs = planned(dry_run(tmp_path, changed(tmp_path, label_jobs=3)))
    assert jobs["label_part"] == 2 * jobs["label"] == 4


def test_a_reconstructor_has_one_cost():
    other = {**SERVED, "cost": COST | {"fit": 3}}
    with pytest.raises(Refusal, match="external states costs"):
        experiment(reconstruction=SERVED, transfer={"reconstructions": [other]})
