import pandas as pd
import pytest

from fsel.experiments.paper.pose_sources import pose_sources
from fsel.experiments.paper.pose_trials import BOTH, ESTIMATED, EXACT, SELECTOR
from fsel.report.numbers import read_csv
from fsel.utils.files import write_table

FACTS = {
    "embedded": [],
    "real": ["mine"],
    "reconstructor": "splats",
    "long_side": 64,
    "descriptor": "lab_hog",
}


def evaluation(path, exact, estimated):
    """Ours and Uniform at K = 10, one target; where the selector alone errs, nonsense."""
    rows = []
    for change, scope, psnr in (
        (EXACT, BOTH, exact),
        (ESTIMATED, BOTH, estimated),
        (ESTIMATED, SELECTOR, 99.0),
    ):
        for method, less in (("less_is_more", 0), ("uniform", 1)):
            rows.append((0, change, scope, method, 0, 10, 3, psnr - less))
    columns = ["draw", "change", "scope", "method", "seed", "k", "target", "psnr"]
    write_table(pd.DataFrame(rows, columns=columns), path, units={}, config="c")
    return path


def test_both_sources_are_means_and_their_difference_is_paired(tmp_path):
    pose_sources(
        [evaluation(tmp_path / "a", 22, 21.5), evaluation(tmp_path / "b", 24, 23.0)],
        tmp_path / "t.tex",
        tmp_path / "t.csv",
        scenes=[("mine", "a"), ("mine", "b")],
        names=["COLMAP", "VGGT"],
        budgets=[10],
        metrics=["psnr"],
        facts=FACTS,
    )
    found = read_csv(tmp_path / "t.csv").set_index(["method", "source"])["mean"]
    assert found["less_is_more", "given"] == 23
    assert found["less_is_more", "other"] == 22.25
    assert found["less_is_more", "difference"] == -0.75
    assert found["uniform", "given"] == 22
    row = next(
        line for line in (tmp_path / "t.tex").read_text().splitlines() if line.startswith("10 & ")
    )
    assert [cell.strip() for cell in row.split("&")][1:3] == ["23.00", "22.25"]
    assert row.count("-0.75") == 1
    assert pytest.approx(found["uniform", "difference"]) == -0.75
