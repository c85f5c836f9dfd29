"""The calibration of `-k auto`: its quantiles by hand, and from captures to the record."""

import json

import numpy as np
import pandas as pd
import pytest
from small_captures import write_ring

import how_many
from fsel.selection.budget import enough


def table_of(rates, totals, frames=(4, 16)):
    """Losses of captures that follow the law exactly."""
    index = pd.MultiIndex.from_tuples(
        [(f"c{at:02d}", n) for at, n in enumerate(totals)], names=["capture", "n"]
    )
    loss = [[a * (k**-0.5 - n**-0.5) for k in frames] for a, n in zip(rates, totals, strict=True)]
    return pd.DataFrame(loss, index, pd.Index(frames, name="k"))


@pytest.mark.parametrize(
    ("count", "share", "rank"),
    [(19, 0.95, 19), (19, 0.9, 18), (9, 0.9, 9), (26, 0.9, 25), (26, 0.05, 1), (26, 0.5, 14)],
)
def test_a_quantile_is_of_one_more_capture_than_there_are(count, share, rank):
    """The rank r of C values is the least with r >= share (C + 1); below a half, from above."""
    values = np.random.default_rng(0).permutation(np.arange(1.0, count + 1))
    assert how_many.conformal(values, share) == rank


def test_exact_losses_give_back_their_rates_and_numbers():
    rates, totals = np.arange(-2.0, 18), [100] * 10 + [9] * 10
    table = table_of(rates, totals)
    table.loc[table.index.get_level_values("n") == 9, 16] = np.nan  # counts as with 4
    record = how_many.calibrated(table)
    assert record["bound"] == [16, 16]  # the 19th of 20
    assert record["low"] == [-2, -2]
    assert record["better"] == [0.1, 0.1]
    assert record["total"] == [9, 100]
    kept = how_many.left_out(table_of(rates, [100] * 20), how_many.auto)
    assert kept["frames"].iloc[0] == enough(record, 0.5, 100)  # the 18th of the others is 16 too
    assert kept["frames"].iloc[-1] == enough(record | {"bound": [15, 15]}, 0.5, 100)
    assert list(kept["loss"] <= 0.5) == [True] * 18 + [False] * 2
    one = how_many.one_number(table_of(rates, [100] * 20))(100)
    assert one == enough(record, 0.5, 100)
    share = how_many.one_share(table_of(rates, [100] * 20))(100)
    assert share == one


def test_from_captures_to_the_record(tmp_path, monkeypatch):
    for name, frames in (("a", 16), ("b", 12)):
        write_ring(tmp_path / name, frames=frames)
    monkeypatch.setattr(how_many, "HOME", tmp_path)
    monkeypatch.setattr(how_many, "FRAMES", (4, 13))
    monkeypatch.setattr(how_many, "SETTINGS", {"steps": 2, "gaussians": 50})
    rows = list(how_many.measure(tmp_path / "rows.jsonl"))
    assert [(row["capture"], row["n"], row["k"]) for row in rows] == [
        ("a", 14, 0),
        ("b", 10, 0),
        ("a", 14, 4),
        ("b", 10, 4),
        ("a", 14, 13),
    ]
    (tmp_path / "rows.jsonl").write_text("\n".join(map(json.dumps, rows)))
    assert not list(how_many.measure(tmp_path / "rows.jsonl"))
    table = how_many.lost(pd.DataFrame(rows))
    assert table.loc[("a", 14), 4] == rows[0]["psnr"] - rows[2]["psnr"]
    monkeypatch.setattr(how_many, "FOLDER", tmp_path)
    how_many.write(table, tmp_path)
    record = json.loads((tmp_path / "how_many.json").read_text())
    assert record["frames"] == [4, 13]
    assert {path.name for path in tmp_path.glob("*.csv")} == {
        "captures.csv",
        "intervals.csv",
        "rules.csv",
    }
