"""The calibration of `-k auto`: its quantiles by hand, and from captures to the record."""

import json

import numpy as np
import pandas as pd
import pytest
from small_captures import write_ring

import how_many


@pytest.mark.parametrize(
    ("count", "share", "rank"),
    [(19, 0.95, 19), (19, 0.9, 18), (9, 0.9, 9), (26, 0.9, 25), (26, 0.05, 1), (26, 0.5, 14)],
)
def test_a_quantile_is_of_one_more_capture_than_there_are(count, share, rank):
    """The rank r of C values is the least with r >= share (C + 1); below a half, from above."""
    values = np.random.default_rng(0).permutation(np.arange(1.0, count + 1))
    assert how_many.conformal(values, share) == rank


def test_a_record_is_of_captures_with_more_frames():
    """Twenty captures lose 0.1, 0.2, ... 2 dB with 16 frames and half of it with 64, where five of
    the first ten have fewer."""
    index = [(f"c{at:02d}", 50 if at < 5 else 100) for at in range(20)]
    first = np.arange(1, 21) / 10
    table = pd.DataFrame(
        {16: first, 64: np.where(np.arange(20) < 5, np.nan, first / 2)},
        pd.MultiIndex.from_tuples(index, names=["capture", "n"]),
    )
    record = how_many.calibrated(table)
    assert record["frames"] == [16, 64]
    assert record["bound"] == [1.9, 0.95]  # the 19th of 20, five of which lose nothing
    assert record["low"] == [0.1, 0.3]
    assert record["total"] == [50, 100]
    kept = how_many.left_out(table, how_many.auto)
    assert (kept["frames"] == kept["n"]).all()  # 64 lose more than 0.5 dB too
    table[64] = np.where(table[64] > 0.5, 0.5, table[64])
    kept = how_many.left_out(table, how_many.auto)
    assert list(kept["frames"]) == [50] * 5 + [64] * 15
    assert list(kept["loss"][:6]) == [0] * 5 + [table[64].iloc[5]]
    inside = how_many.covered(table)
    assert inside["within"].iloc[0] == 18 / 20  # 1.9 and 2 dB are beyond the others' 18th
    share = how_many.one_share(table)
    assert share(100) == 64


def test_from_captures_to_the_record(tmp_path, monkeypatch):
    for name, frames in (("a", 16), ("b", 12)):
        write_ring(tmp_path / name, frames=frames)
    monkeypatch.setattr(how_many, "HOME", tmp_path)
    monkeypatch.setattr(how_many, "FRAMES", (4, 6))
    monkeypatch.setattr(how_many, "SETTINGS", {"steps": 2, "gaussians": 50})
    rows = list(how_many.measure(tmp_path / "rows.jsonl"))
    assert [(row["capture"], row["n"], row["k"]) for row in rows] == [
        ("a", 14, 0),
        ("b", 10, 0),
        ("a", 14, 4),
        ("b", 10, 4),
        ("a", 14, 6),
        ("b", 10, 6),
    ]
    (tmp_path / "rows.jsonl").write_text("\n".join(map(json.dumps, rows)))
    assert not list(how_many.measure(tmp_path / "rows.jsonl"))
    table = how_many.lost(pd.DataFrame(rows))
    assert table.loc[("a", 14), 4] == rows[0]["psnr"] - rows[2]["psnr"]
    monkeypatch.setattr(how_many, "FOLDER", tmp_path)
    how_many.write(pd.DataFrame(rows), tmp_path)
    record = json.loads((tmp_path / "how_many.json").read_text())
    assert record["frames"] == [4, 6]
    assert {path.name for path in tmp_path.glob("*.csv")} == {
        "captures.csv",
        "intervals.csv",
        "rules.csv",
    }
