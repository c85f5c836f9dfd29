"""Further reconstructors of the same picks: what is planned for them, and what is refused."""

import pytest
from dry_runs import changed, dry_run, planned, refusal

FIRST = {"long_side": 48}
SECOND = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3}}


def test_a_further_reconstructor_adds_evaluations_and_tables_and_no_selection(tmp_path):
    usual = planned(dry_run(tmp_path, changed(tmp_path, reconstruction=FIRST)))
    both = planned(dry_run(tmp_path, changed(tmp_path, reconstruction=[FIRST, SECOND])))
    added = {rule: n for rule, n in (both - usual).items() if rule != "total"}
    assert added == {"evaluate_further": 2, "ksweep_further": 1, "heatmap_further": 1}
    assert not usual - both


def test_its_tables_lie_in_a_folder_of_its_name(tmp_path):
    config = changed(tmp_path, reconstruction=[FIRST, SECOND, SECOND | {"as": "g.2"}])
    wanted = ["g.2/ksweep.tex", "gaussians/handsign.tex", "g.2/seedvar.csv"]
    asked = planned(dry_run(tmp_path, config, *(f"results/smoke/tables/{w}" for w in wanted)))
    assert asked["evaluate_further"] == 4
    assert asked["handsign_further"] == asked["seedvar_further"] == asked["ksweep_further"] == 1
    unknown = dry_run(tmp_path, config, "results/smoke/tables/other/ksweep.tex")
    assert (
        "'other' is not among the further ones, ['gaussians', 'g.2']"
        in unknown.stdout + unknown.stderr
    )


@pytest.mark.parametrize(
    ("reconstruction", "parts"),
    [
        ([], ["reconstruction", "should be non-empty"]),
        ([FIRST, FIRST], ["reconstruction has two named 'splats'", "`as`"]),
        ([FIRST, SECOND | {"as": "a/b"}], ["reconstruction[1].as", "'a/b' does not match"]),
        ([FIRST, {"name": "nerf"}], ["reconstruction[1].name", "'nerf' is not one of ['splats'"]),
        ({"settings": {"colour": 1}}, ["reconstruction, splats: reconstructor 'splats'", "colour"]),
        (
            [FIRST, SECOND | {"settings": {"steps": -1}}],
            ["reconstruction, gaussians", "steps must be an integer of at least 0, got -1"],
        ),
    ],
)
def test_a_reconstructor_that_cannot_work_is_refused_before_any_job(
    tmp_path, reconstruction, parts
):
    text = refusal(tmp_path, changed(tmp_path, reconstruction=reconstruction))
    for part in [*parts, "Hint: "]:
        assert part in text
