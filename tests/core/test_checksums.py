"""Damage of each kind of artefact is seen, named, and told how to mend."""

import hashlib
import os
import shlex

import numpy as np
import pandas as pd
import pytest

from fsel.core import checksums
from fsel.core.capture import Capture
from fsel.core.checksums import Damaged, beside, check, damages, write
from fsel.core.files import mapped_array, read_table
from fsel.selectors.scorer import SHAPES, Linear, Network

WRITERS = {
    "a.parquet": lambda path: pd.DataFrame({"x": np.arange(50)}).to_parquet(path),
    "a.npy": lambda path: np.save(path, np.arange(50)),
    "a.safetensors": lambda path: Network(
        {name: np.ones(shape, np.float32) for name, shape in SHAPES.items()}
    ).save(path),
    "a.json": lambda path: Linear({"d_min_o": 1.5}).save(path),
}


@pytest.fixture(params=WRITERS)
def artefact(request, tmp_path):
    path = tmp_path / request.param
    WRITERS[request.param](path)
    write(path)
    return path


def changed(path, content):
    """Other bytes with the old time stamp."""
    before = path.stat()
    path.write_bytes(content)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def flipped(content, at):
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def test_whole_files_pass_and_files_without_a_checksum(artefact):
    check(artefact)
    beside(artefact).unlink()
    changed(artefact, b"")
    check(artefact)


def test_a_cut_file_is_named_with_both_lengths(artefact):
    content = artefact.read_bytes()
    changed(artefact, content[:-1])
    with pytest.raises(Damaged) as refused:
        check(artefact)
    text = f"{artefact}: has {len(content) - 1} bytes, and had {len(content)} when it was made"
    assert str(refused.value).startswith(text)
    assert f"snakemake --cores 1 --force {shlex.quote(str(artefact))}" in str(refused.value)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.999])
def test_one_flipped_bit_is_seen_anywhere(artefact, share):
    content = artefact.read_bytes()
    changed(artefact, flipped(content, int(share * len(content))))
    with pytest.raises(Damaged, match=f"{artefact.name}: its bytes are not those"):
        check(artefact)


def test_large_files_are_read_through_when_the_file_system_changed_them(artefact, monkeypatch):
    monkeypatch.setattr(checksums, "ALWAYS", 0)
    read = []
    whole = checksums.sha256_of
    monkeypatch.setattr(checksums, "sha256_of", lambda path: read.append(path) or whole(path))
    check(artefact)
    assert read == []
    os.utime(artefact)  # as Snakemake does with every output
    record = beside(artefact).stat()
    os.utime(beside(artefact), ns=(record.st_atime_ns, artefact.stat().st_ctime_ns - 1))
    check(artefact)
    check(artefact)
    assert read == [artefact]
    changed(artefact, flipped(artefact.read_bytes(), 3))
    os.utime(beside(artefact), ns=(record.st_atime_ns, artefact.stat().st_ctime_ns - 1))
    with pytest.raises(Damaged):
        check(artefact)


def test_the_checksum_is_one_that_sha256sum_reads(artefact):
    lines = beside(artefact).read_text().splitlines()
    found = hashlib.sha256(artefact.read_bytes()).hexdigest()
    assert lines == [f"# {artefact.stat().st_size} bytes", f"{found}  {artefact.name}"]


def test_a_damaged_checksum_is_named(artefact):
    beside(artefact).write_text("x")
    with pytest.raises(Damaged, match=f"{beside(artefact).name}: not a checksum"):
        check(artefact)


def test_several_damages_are_told_together(tmp_path):
    for name in "abc":
        (tmp_path / name).write_text(name)
        write(tmp_path / name)
    changed(tmp_path / "a", b"")
    changed(tmp_path / "c", b"x")
    missing = tmp_path / "d"
    found = damages([tmp_path / name for name in "cba"] + [missing])
    assert list(found) == [tmp_path / "a", tmp_path / "c"]


def test_readers_name_damaged_files_that_have_no_checksum(tmp_path):
    for name, read in {"a.parquet": read_table, "a.npy": mapped_array}.items():
        path = tmp_path / name
        WRITERS[name](path)
        for content in (path.read_bytes()[:-30], b"", b"x" * 40):
            path.write_bytes(content)
            with pytest.raises(ValueError, match=f"{path}: not a "):
                read(path)
    with pytest.raises(FileNotFoundError, match=r"frames\.parquet"):
        Capture.load(tmp_path)
