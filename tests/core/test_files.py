"""Tables and texts on disk: whole or not at all, with units and digest."""

import json
import os

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from fsel.core import files
from fsel.core.files import (
    atomic,
    by_column,
    chosen,
    digest,
    fingerprint,
    from_arrow,
    read_columns,
    repeated,
    stacked,
    write_table,
)


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def cut_off() -> None:
        with atomic(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError("cut off")

    with pytest.raises(RuntimeError, match="cut off"):
        cut_off()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_tables_carry_units_and_digest(tmp_path):
    path = tmp_path / "t.parquet"
    write_table(pd.DataFrame({"d": [1.0]}), path, units={"d": "m"}, config="abc")
    stored = pq.read_schema(path).metadata
    assert (json.loads(stored[b"units"]), stored[b"config"]) == ({"d": "m"}, b"abc")
    assert pd.read_parquet(path)["d"].tolist() == [1.0]
    with pytest.raises(ValueError, match="units for \\['e'\\]"):
        write_table(pd.DataFrame({"d": [1.0]}), path, units={"e": "m"}, config="")


def test_digests_follow_content_not_order():
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1}) != digest({"a": 1, "b": 3})


def test_files_are_known_by_content_and_large_ones_by_size_and_time(tmp_path, monkeypatch):
    path = tmp_path / "images.npy"

    def mark(text, time=1):
        path.write_text(text)
        os.utime(path, ns=(time, time))
        return fingerprint([path], {})

    assert mark("12345") == mark("12345", 2) != mark("54321")
    monkeypatch.setattr(files, "LARGE", 4)
    assert mark("12345") == mark("54321") != mark("54321", 2)
    assert mark("12345") != mark("123456")


TABLES = {
    "numbers": {
        "i": np.arange(3),
        "f": np.array([0.1, np.inf, -1e-300]),
        "small": np.array([1, 2, 255], np.uint8),
        "single": np.array([0.1, -0.0, 3], np.float32),
        "strided": np.arange(12.0).reshape(3, 4)[:, 1],
        "counted": range(3),
    },
    "truths": {"b": np.arange(19) % 3 == 0},
    "texts": {
        "object": np.array(["a", "", "größer"], object),
        "fixed": np.array(["x", "yy", "zzz"]),
        "tuple": ("p", "q", "r"),
    },
    "lists": {
        "matrix": np.arange(6, dtype=np.float32).reshape(2, 3),
        "ragged": [np.array([1, 2, 3]), np.empty(0, np.int64)],
    },
    "no rows": {"i": np.empty(0, np.int64), "s": np.empty(0, object), "m": np.empty((0, 4))},
}


@pytest.mark.parametrize("name", TABLES)
def test_a_table_comes_back_and_is_what_pandas_would_have_written(name, tmp_path):
    table, ours, theirs = TABLES[name], tmp_path / "ours", tmp_path / "theirs"
    write_table(table, ours, units={}, config="c")
    rows = {column: list(values) for column, values in table.items()}
    pd.DataFrame(rows).astype({c: v.dtype for c, v in table.items() if flat(v)}).to_parquet(theirs)
    for path in (ours, theirs):
        read = read_columns(path)
        assert list(read) == list(table)
        for column, values in table.items():
            for found, expected in zip(read[column], values, strict=True):
                np.testing.assert_array_equal(found, expected)
            if flat(values):
                assert read[column].dtype == values.dtype
    if "m" not in table:
        pd.testing.assert_frame_equal(pd.read_parquet(ours), pd.read_parquet(theirs))


def flat(values):
    return isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "biuf"


def test_slices_of_arrow_arrays_start_where_they_start():
    for values in ([True, False, True, True], [1, 2, 3, 4], [[1], [2, 3], [], [4, 5]]):
        part = pa.array(values)[1:]
        assert [np.asarray(v).tolist() for v in from_arrow(part)] == values[1:]


@pytest.mark.parametrize("values", [[1, None], [1.5, None], ["a", None], [True, None], [[1], None]])
def test_missing_values_are_refused_with_the_file(values, tmp_path):
    path = tmp_path / "holes.parquet"
    pq.write_table(pa.table({"x": values}), path)
    with pytest.raises(ValueError, match=r"holes\.parquet.*missing values in x"):
        read_columns(path)


def test_rows_are_taken_repeated_and_stacked():
    table = by_column([{"a": 1, "s": [1, 2]}, {"a": 2, "s": [3, 4]}])
    both = stacked([table | repeated({"n": "x"}, 2), table | repeated({"n": "longer"}, 2)])
    assert both["n"].tolist() == ["x", "x", "longer", "longer"]
    part = chosen(both, both["a"] == 2)
    assert part["s"].tolist() == [[3, 4], [3, 4]]
    assert chosen(both, slice(-1, None))["n"].tolist() == ["longer"]


def test_json_has_null_for_numbers_that_are_not_finite():
    content = {"a": [1.5, float("inf"), (float("nan"), "²")], "b": {"c": -float("inf"), "d": True}}
    made = files.json_text(content)
    assert json.loads(made, parse_constant=pytest.fail) == {
        "a": [1.5, None, [None, "²"]],
        "b": {"c": None, "d": True},
    }
