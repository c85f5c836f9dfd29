"""Results in a storage: every file that a job needs is declared, since no other reaches it."""

import shutil

import numpy as np
import pytest
from dry_runs import SMOKE, changed, snakemake

pytest.importorskip("snakemake_storage_plugin_fs", reason="no plugin for storage in a folder")
if not shutil.which("rsync"):
    pytest.skip("rsync, by which the plugin copies, is not here", allow_module_level=True)

TABLE = "results/smoke/tables/ksweep.csv"


def test_tables_in_a_storage_are_those_of_a_local_run(tmp_path):
    """One capture of an object, whose masks count, and the scorers that ship."""
    co3d = SMOKE["datasets"]["co3d"] | {"scenes": {"evaluation": 1}}
    few = {"datasets": {"co3d": co3d}, "budgets": [5], "draws": 1, "oracle": {"draws": 0}}
    gaussians = {"name": "gaussians", "long_side": 32, "settings": {"steps": 3, "gaussians": 200}}
    config = changed(tmp_path, **few, reconstruction=gaussians)
    here, scratch, bucket = (tmp_path / name for name in ("here", "scratch", "bucket"))
    here.mkdir()
    scratch.mkdir()
    storage = ["--default-storage-provider", "fs", "--default-storage-prefix", str(bucket)]
    for folder, words in ((here, []), (scratch, storage)):
        done = snakemake(folder, [config], "--cores", "1", *words, "--", TABLE)
        assert done.returncode == 0, done.stdout + done.stderr
    again = snakemake(scratch, [config], "--cores", "1", *storage, "--", TABLE)
    assert "Nothing to be done" in again.stdout + again.stderr
    assert (bucket / TABLE).read_bytes() == (here / TABLE).read_bytes()
    assert np.load(bucket / "results/smoke/co3d/evaluation00/masks.npy").any()
    # local copies go as soon as no other job needs them
    assert not list((scratch / ".snakemake" / "storage").rglob("images.npy"))
