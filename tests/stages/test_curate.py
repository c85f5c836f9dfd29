"""Many scenes that are selected from and not evaluated."""

import pandas as pd
import pytest
import yaml
from dry_runs import dry_run, planned
from small_captures import write_ring

import fsel
from fsel.stages.curate import curate, selections

REQUEST = {"k": 5, "targets": "every:8", "method": "fsel", "patience": 0}


def test_scenes_have_the_picks_of_select_and_broken_ones_stop_no_other(tmp_path):
    for name in ("one", "two"):
        write_ring(tmp_path / name, seed=len(name))
    (tmp_path / "broken").mkdir()
    scenes, part, table = ["broken", "one", "two"], tmp_path / "part", tmp_path / "table.csv"
    curate(
        [tmp_path / name for name in scenes],
        part,
        scenes={name: {"seed": 0, "points": "layout"} for name in scenes},
        request=REQUEST,
        form={"link": False, "long_side": None},
        config="",
    )
    chosen = fsel.select(tmp_path / "one", 5, "every:8", patience=0)
    picks = pd.read_parquet(part / "one" / "selections.parquet")
    assert tuple(picks["name"]) == chosen.names
    assert (picks["frame"] == chosen.indices).all()
    assert set(fsel.read_capture(part / "one" / "train").names) == set(chosen.names)
    selections([part], table)
    listed = pd.read_csv(table).set_index("scene")
    assert listed["picked"].to_dict() == {"broken": 0, "one": 5, "two": 5}
    assert "broken: no known layout" in listed.loc["broken", "refused"]
    (part / "scenes.csv").write_text("scene,frames,picked,refused\nbroken,0,0,why\n")
    with pytest.raises(ValueError, match="1 of 1 scenes are refused"):
        selections([part], table)


def configured(folder, each=20, **request):
    for number in range(5):
        (folder / "data" / f"scene{number}").mkdir(parents=True, exist_ok=True)
    mine = {"label": "Mine", "root": "data", "scenes": "all"}
    asked = {"scenes_per_job": each, "request": request}
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump({"datasets": {"mine": mine}, "selections": asked}))
    return path


def test_jobs_take_scenes_together_and_nothing_else_is_made(tmp_path):
    plan = planned(dry_run(tmp_path, configured(tmp_path, each=2), "selections"))
    assert plan == {"curate": 3, "selections": 1, "total": 4}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"method": "fsell"}, "fsell"),
        ({"targets": "every:1"}, "every:1"),
        ({"patience": 5, "targets": "orbit"}, "with patience only k"),
    ],
)
def test_what_no_job_could_select_is_refused_before_any(tmp_path, changes, reason):
    result = dry_run(tmp_path, configured(tmp_path, **changes), "selections")
    assert result.returncode != 0
    assert reason in result.stdout + result.stderr
