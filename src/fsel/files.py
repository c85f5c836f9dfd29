"""Writing and reading the workflow's tables: atomically, with units and a digest of the config."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends without an error.

    A job that is killed half-way leaves the old file, or none, but never half a file.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(text: str, path: str | Path) -> None:
    """Write a text file atomically."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def digest(values: Mapping[str, Any]) -> str:
    """Twelve hexadecimal digits of a mapping's content, whatever the order of its keys."""
    text = json.dumps(dict(values), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def fingerprint(paths: Iterable[str | Path], values: Mapping[str, Any]) -> str:
    """Twelve hexadecimal digits of files' content and of a mapping: what a result depends on."""
    total = hashlib.sha256(digest(values).encode())
    for path in paths:
        total.update(Path(path).read_bytes())
    return total.hexdigest()[:12]


def write_table(
    frame: pd.DataFrame, path: str | Path, *, units: Mapping[str, str], config: str
) -> None:
    """Write a Parquet file whose schema metadata tells units and the config's digest.

    Args:
        frame: the rows; its index is dropped.
        path: where to.
        units: column -> unit, for columns that have one.
        config: digest of the parameters that made the rows, see `digest`.

    Raises:
        ValueError: when `units` names a column that is not there.
    """
    import pyarrow as pa  # here: the command `fsel` writes no tables and is installed without it
    import pyarrow.parquet as pq

    unknown = set(units) - set(frame.columns)
    if unknown:
        raise ValueError(f"{path}: units for {sorted(unknown)}, columns are {list(frame.columns)}")
    table = pa.Table.from_pandas(frame, preserve_index=False)
    metadata = {b"units": json.dumps(dict(units)).encode(), b"config": config.encode()}
    table = table.replace_schema_metadata({**table.schema.metadata, **metadata})
    with atomic(path) as temporary:
        pq.write_table(table, temporary)


def table_metadata(path: str | Path) -> tuple[dict[str, str], str]:
    """The units and the config digest that `write_table` stored."""
    import pyarrow.parquet as pq

    metadata = pq.read_schema(path).metadata
    return json.loads(metadata[b"units"]), metadata[b"config"].decode()


def subsets_column(subsets: np.ndarray) -> list[list[int]]:
    """(n, K) frames as a list column."""
    return np.asarray(subsets).tolist()
