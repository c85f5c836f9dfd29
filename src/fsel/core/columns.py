"""Tables as columns of arrays, and Arrow's arrays of them, without pandas.

pandas takes longer to import than most jobs of the workflow take, and pyarrow imports it wherever
it converts an array of NumPy: here memory is handed over as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa

Columns = Mapping[str, Any]
"""Name -> (n,) numbers, booleans or texts, (n, m) numbers, or n arrays of numbers: a table of n
rows. A DataFrame is read as one too."""


def by_column(rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Columns of rows that all have the same names."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def by_row(table: Columns) -> list[dict[str, Any]]:
    """Rows of a table, their values as Python's own."""
    columns = (np.asarray(table[name]).tolist() for name in table)
    return [dict(zip(table, row, strict=True)) for row in zip(*columns, strict=True)]


def chosen(table: Columns, rows: np.ndarray | slice) -> dict[str, np.ndarray]:
    """Some rows of a table, by number, (n,) bool or slice."""
    return {name: np.asarray(table[name])[rows] for name in table}


def repeated(values: Mapping[str, Any], count: int) -> dict[str, np.ndarray]:
    """Columns that each hold one value in all rows."""
    return {name: np.repeat(value, count) for name, value in values.items()}


def stacked(tables: Sequence[Columns]) -> dict[str, np.ndarray]:
    """The rows of tables of the same columns, one table after another."""
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def lines(table: Columns) -> str:
    """The rows of a table, a line each of names and values, for a log."""
    return "\n".join(", ".join(map(_entry, row, row.values())) for row in by_row(table))


def _entry(name: str, value: Any) -> str:
    return f"{name} {value:.5g}" if isinstance(value, float) else f"{name} {value}"


def to_arrow(column: Any) -> pa.Array:
    """An Arrow array of a column as `Columns` describes it; one of arrays becomes lists."""
    import pyarrow as pa

    if len(column) and np.ndim(column[0]):
        ends = np.cumsum([0, *map(len, column)]).astype(np.int32)
        return pa.ListArray.from_arrays(to_arrow(ends), to_arrow(np.concatenate(list(column))))
    values = np.ascontiguousarray(column)
    if values.dtype.kind in "OU":
        texts = [text.encode() for text in values]
        ends = np.cumsum([0, *map(len, texts)]).astype(np.int32)
        kind, buffers = pa.string(), [pa.py_buffer(ends), pa.py_buffer(b"".join(texts))]
    else:
        kind = pa.from_numpy_dtype(values.dtype)
        bits = np.packbits(values, bitorder="little") if values.dtype == bool else values
        buffers = [pa.py_buffer(bits)]
    return pa.Array.from_buffers(kind, len(values), [None, *buffers])


def from_arrow(array: pa.Array) -> np.ndarray:
    """A column of an Arrow array; no value of it is missing.

    Lists of one length become a matrix, others an array of arrays.
    """
    import pyarrow as pa

    if pa.types.is_list(array.type):
        ends = from_arrow(array.offsets)
        values = from_arrow(array.values)[ends[0] : ends[-1]]
        if len(set(np.diff(ends).tolist())) == 1:
            return values.reshape(len(array), -1)
        return np.fromiter(np.split(values, ends[1:-1] - ends[0]), object, len(array))
    if pa.types.is_boolean(array.type):
        bits = np.unpackbits(np.frombuffer(array.buffers()[1], np.uint8), bitorder="little")
        return bits[array.offset :][: len(array)].astype(bool)
    if pa.types.is_integer(array.type) or pa.types.is_floating(array.type):
        return np.array(np.from_dlpack(array))
    return np.array(array.to_pylist(), object)
