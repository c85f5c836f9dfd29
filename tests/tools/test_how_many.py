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


def test_captures_unlike_those_measured_say_how_wide_intervals_are():
    """Five with few frames lose 0 to 4 dB, the median 2; of five with more, four lose 8 or less."""
    index = pd.MultiIndex.from_tuples(
        [(f"c{at}", 50 + at) for at in range(10)], names=["capture", "n"]
    )
    table = pd.DataFrame({20: [4.0, 1, 2, 3, 0, 8, 8, -4, 2, 5]}, index)
    # off by 6, 6, -6, 0 and 3 dB where the interval reaches 2: the sixth of five is the most
    assert how_many.widened(table) == 3.0
    assert how_many.widened(table.iloc[:4]) == 1.0  # two say nothing of an interval


def test_from_captures_to_the_record(tmp_path, monkeypatch):
    for name, frames in (("a", 16), ("b", 12)):
        write_ring(tmp_path / name, frames=frames)
    for name, value in (("HOME", tmp_path), ("FRAMES", (6, 4)), ("STEPS", 7)):
        monkeypatch.setattr(how_many, name, value)
    fitted, splats = [], how_many.fsel.fit

    def fit(capture, frames, name, **settings):
        fitted.append((len(frames), settings["steps"]))
        return splats(capture, frames)

    monkeypatch.setattr(how_many.fsel, "fit", fit)
    rows = list(how_many.measure(tmp_path / "rows.jsonl"))
    cells = [(row["kind"], row["k"], row["capture"], row["n"]) for row in rows]
    every = [(k, name, n) for k in (0, 6, 4) for name, n in (("a", 14), ("b", 10))]
    assert cells == [
        (kind, *cell)
        for kind in ("large", "small", "even", "in_proportion")
        for cell in every[0 if kind in ("large", "small") else 2 :]
    ]
    assert [frames for frames, _ in fitted] == [cell[1] or cell[3] for cell in cells]
    # 7 steps times 6/14, 6/10, 4/14 and 4/10 frames
    assert [steps for _, steps in fitted] == [7] * 16 + [3, 4, 2, 2]
    (tmp_path / "rows.jsonl").write_text("\n".join(map(json.dumps, rows)))
    assert not list(how_many.measure(tmp_path / "rows.jsonl"))
    table = how_many.lost(pd.DataFrame(rows))
    assert table.loc[("a", 14), 4] == rows[0]["psnr"] - rows[4]["psnr"]
    even = how_many.lost(pd.DataFrame(rows), "even")
    assert even.loc[("b", 10), 6] == rows[7]["psnr"] - rows[13]["psnr"]
    monkeypatch.setattr(how_many, "FOLDER", tmp_path)
    how_many.write(pd.DataFrame(rows), tmp_path)
    record = json.loads((tmp_path / "how_many.json").read_text())
    assert record["frames"] == [4, 6]
    files = {"captures", "intervals", "kinds", "rules"}
    assert {path.stem for path in tmp_path.glob("*.csv")} == files
    kinds = pd.read_csv(tmp_path / "kinds.csv")
    assert kinds["even"].to_list() == pytest.approx(even.mean().to_list(), abs=1e-6)
    assert kinds["captures"].to_list() == [2, 2]
