"""Tables and texts on disk: whole or not at all, with units and digest."""

import json
import os

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from fsel.core import files
from fsel.core.files import atomic, digest, fingerprint, host, write_table


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


def test_equal_tables_are_equal_bytes(tmp_path):
    for name in "ab":
        frame = pd.DataFrame({"x": np.arange(5), "s": [[1, 2]] * 5})
        write_table(frame, tmp_path / name, units={}, config="")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_digests_follow_content_not_order(tmp_path):
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1}) != digest({"a": 1, "b": 3})
    path = tmp_path / "f"
    path.write_text("1")
    first = fingerprint([path], {})
    path.write_text("2")
    assert fingerprint([path], {}) != first


def test_unfinished_files_are_told_apart_by_machine_and_process(tmp_path):
    """Two jobs of a cluster write one file; what is a day old, or left here, is of none of them."""
    path = tmp_path / "images.npy"
    other, forgotten = tmp_path / ".node-7.12.images.npy", tmp_path / ".node-7.13.images.npy"
    unlike, left = tmp_path / ".images.npy", tmp_path / f".{host()}.999999999.images.npy"
    for file in (other, forgotten, unlike, left):
        file.write_text("half")
    for file in (forgotten, unlike):
        os.utime(file, (0, 0))
    with atomic(path) as temporary:
        temporary.write_text("whole")
        assert temporary.name == f".{host()}.{os.getpid()}.images.npy"
    assert sorted(tmp_path.iterdir()) == sorted([path, other, unlike])
    assert path.read_text() == "whole"


def test_large_files_are_known_by_size_and_time(tmp_path, monkeypatch):
    """The fingerprint of a large file does not read it; a change of either is seen."""
    monkeypatch.setattr(files, "LARGE", 4)
    path = tmp_path / "images.npy"
    path.write_text("12345")
    os.utime(path, ns=(1, 1))
    first = fingerprint([path], {})
    path.write_text("54321")
    os.utime(path, ns=(1, 1))
    assert fingerprint([path], {}) == first
    os.utime(path, ns=(2, 2))
    assert fingerprint([path], {}) != first
