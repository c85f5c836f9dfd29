"""Tables without pandas: what pandas and pyarrow's own conversions read and write."""

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from fsel.core.columns import by_column, chosen, from_arrow, lines, repeated, stacked, to_arrow
from fsel.core.files import read_columns, write_table

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
            assert len(read[column]) == len(values)
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


def test_arrow_agrees_on_what_an_array_is():
    assert to_arrow(np.array([True, False])).equals(pa.array([True, False]))
    assert to_arrow(["a", "é"]).equals(pa.array(["a", "é"]))
    assert to_arrow([[1, 2], [3]]).equals(pa.array([[1, 2], [3]]))


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


def test_a_log_has_a_line_a_row():
    table = {"split": np.array(["train", "test"]), "loss": np.array([1 / 3, 2.0]), "epoch": [1, 1]}
    assert lines(table) == "split train, loss 0.33333, epoch 1\nsplit test, loss 2, epoch 1"
