"""Files that are written whole or not at all, and tables in Parquet without pandas.

pandas takes longer to import than most jobs of the workflow take, and pyarrow imports it wherever
it converts an array of NumPy: here memory is passed on as it is. NumPy is imported where it is
used: the rules of the workflow are read without it.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shutil
import socket
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import pyarrow as pa

File = str | Path
Files = Sequence[File]
Columns = Mapping[str, Any]
"""Name -> (n,) numbers, booleans or texts, (n, m) numbers, or n arrays of numbers: a table of n
rows. A DataFrame is read as one too."""

LARGE = 1 << 24  # bytes; a file from here on is known by its size and time, not by its content


def cache() -> Path:
    """Return the folder of found poses and fetched weights: FSEL_CACHE, or in the user's cache."""
    own = os.environ.get("FSEL_CACHE")
    shared = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(own) if own else Path(shared) / "fsel"


def unfinished(path: Path) -> Path:
    """Return the name beside `path` under which this process writes it, and remove what dead
    processes of this machine left there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    pattern = re.compile(rf"\.{host()}\.(\d{{1,9}})\.{re.escape(path.name)}")
    for other in path.parent.iterdir():
        parts = pattern.fullmatch(other.name)
        if parts and not running(int(parts[1])):
            shutil.rmtree(other) if other.is_dir() else other.unlink(missing_ok=True)
    return path.with_name(f".{host()}.{os.getpid()}.{path.name}")


def emptied(folder: Path) -> Path:
    """Return a folder after making it anew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


def host() -> str:
    """Return the name of this machine, as a part of a file's name."""
    return re.sub(r"[^\w-]", "-", socket.gethostname())


def running(process: int) -> bool:
    """Check whether a process of this machine runs, by its number; on Windows, whether it may."""
    try:
        if os.name != "nt":  # where signal 0 is not a question
            os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        pass
    return True


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` that takes its place when the block succeeds."""
    path = Path(path)
    temporary = unfinished(path)
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(text: str, path: str | Path) -> None:
    """Write a text file atomically."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def json_text(content: Any) -> str:
    """Return JSON that every parser reads: numbers that are not finite become null."""

    def known(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {key: known(part) for key, part in value.items()}
        if isinstance(value, list | tuple):
            return [known(part) for part in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(known(content), indent=1, ensure_ascii=False, allow_nan=False)


def digest(values: Mapping[str, Any]) -> str:
    """Return twelve hexadecimal digits of a mapping's content, whatever the order of its keys."""
    text = json.dumps(dict(values), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def fingerprint(paths: Iterable[str | Path], values: Mapping[str, Any]) -> str:
    """Return twelve hexadecimal digits of files and of a mapping; size and time of change stand for
    the content of large files."""
    total = hashlib.sha256(digest(values).encode())
    for path in map(Path, paths):
        stat = path.stat()
        if stat.st_size < LARGE:
            total.update(path.read_bytes())
        else:
            total.update(f"{path.name} {stat.st_size} {stat.st_mtime_ns}".encode())
    return total.hexdigest()[:12]


def write_table(
    table: Columns | pd.DataFrame, path: str | Path, *, units: Mapping[str, str], config: str
) -> None:
    """Write a Parquet file, without a DataFrame's index, whose schema metadata has units, column ->
    unit, and the config's `digest`."""
    unknown = set(units) - set(table)
    if unknown:
        raise ValueError(f"{path}: units for {sorted(unknown)}, columns are {list(table)}")
    write_parquet(table, path, {"units": json.dumps(dict(units)), "config": config})


def write_parquet(
    table: Columns | pd.DataFrame, path: str | Path, metadata: Mapping[str, str]
) -> None:
    """Write a Parquet file whose schema has metadata."""
    parquet = _parquet()
    import pyarrow as pa

    if isinstance(table, Mapping):
        rows = pa.table({name: to_arrow(table[name]) for name in table})
    else:
        rows = pa.Table.from_pandas(table, preserve_index=False)
    rows = rows.replace_schema_metadata({**(rows.schema.metadata or {}), **metadata})
    with atomic(path) as temporary:
        parquet.write_table(rows, temporary)


def read_table(path: str | Path) -> pd.DataFrame:
    """Read a Parquet file; ValueError for one that is damaged, by name."""
    import pandas as pd  # here: it takes longer to import than a selection takes

    with _readable(path):
        return pd.read_parquet(path)


def read_columns(path: str | Path) -> dict[str, np.ndarray]:
    """Read a Parquet file; ValueError for one that is damaged or lacks values, by name."""
    parquet = _parquet()
    with _readable(path), parquet.ParquetFile(path) as file:
        table = file.read()
        if lacking := [name for name in table.column_names if table[name].null_count]:
            raise ValueError(f"missing values in {', '.join(lacking)}")
        return {name: from_arrow(table[name].combine_chunks()) for name in table.column_names}


def read_metadata(path: str | Path) -> dict[str, str]:
    """Read the metadata of a Parquet file's schema."""
    stored = _parquet().read_schema(path).metadata or {}
    return {name.decode(): text.decode() for name, text in stored.items()}


def _parquet() -> ModuleType:
    """Import what reads and writes Parquet, which `fsel` is installed without."""
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise ImportError(
            "tables and saved captures are Parquet files, and pyarrow is not installed. "
            "Hint: pip install 'fsel[workflow]', or pyarrow"
        ) from error
    return pyarrow.parquet


@contextmanager
def _readable(path: str | Path) -> Iterator[None]:
    from pyarrow import ArrowException

    try:
        yield
    except FileNotFoundError:
        raise
    except (ArrowException, OSError, ValueError) as error:
        said = " ".join(str(error).split())
        raise ValueError(f"{path}: not a readable Parquet file ({said})") from error


def mapped_array(path: str | Path) -> np.ndarray:
    """Open a .npy file as a read-only map; ValueError for one that is damaged, by name."""
    import numpy as np

    try:
        return np.load(path, mmap_mode="r")
    except (ValueError, EOFError) as error:
        raise ValueError(f"{path}: not a whole .npy file ({error})") from error


def by_column(rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Return columns of rows that all have the same names."""
    import numpy as np

    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def chosen(table: Columns, rows: np.ndarray | slice) -> dict[str, np.ndarray]:
    """Return some rows of a table, by number, (n,) bool or slice."""
    import numpy as np

    return {name: np.asarray(table[name])[rows] for name in table}


def repeated(values: Mapping[str, Any], count: int) -> dict[str, np.ndarray]:
    """Return columns that each hold one value in all rows."""
    import numpy as np

    return {name: np.repeat(value, count) for name, value in values.items()}


def stacked(tables: Sequence[Columns]) -> dict[str, np.ndarray]:
    """Return the rows of tables of the same columns, one table after another."""
    import numpy as np

    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def to_arrow(column: Any) -> pa.Array:
    """Return a column, see `Columns`, as an Arrow array; one of arrays becomes lists."""
    import numpy as np
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
    """Return a column without missing values; lists of one length become a matrix."""
    import numpy as np
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
