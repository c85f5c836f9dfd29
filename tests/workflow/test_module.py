"""The workflow as a module of another one, from a clone and from a hosted repository."""

import shutil
import subprocess
import sys

import pytest
from dry_runs import ROOT, changed, dry_run, forked, planned

IMPORTER = """
configfile: "config.yaml"

module fsel:
    snakefile: {snakefile}
    config: config

use rule * from fsel as {name}

onstart:
    fsel.onstart()
"""
TARGET = "results/smoke/co3d/object00/images.npy"


@pytest.fixture
def hosted(tmp_path, monkeypatch):
    """An address whose repository git finds in a folder; nothing else reaches the importer."""
    repository = tmp_path / "hosted"
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, repository / name)
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b", "-C", str(repository)]
    for words in (["init", "-q", "-b", "main"], ["add", "."], ["commit", "-q", "-m", "all"]):
        subprocess.run([*git, *words], check=True)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("GIT_CONFIG_COUNT", "1")
    monkeypatch.setenv("GIT_CONFIG_KEY_0", f"url.{repository.as_uri()}.insteadOf")
    monkeypatch.setenv("GIT_CONFIG_VALUE_0", "https://github.com/group/fsel")
    return 'github("group/fsel", path="workflow/Snakefile", branch="main")'


def imported(folder, snakefile, name, *words):
    """Run a workflow that imports this one, with the smoke configuration of its own."""
    folder.mkdir()
    changed(folder)
    (folder / "Snakefile").write_text(IMPORTER.format(snakefile=snakefile, name=name))
    return forked(folder, "--workflow-profile", "none", "--cores", "1", *words)


def test_a_clone_is_imported_under_other_names(tmp_path):
    path = repr(str(ROOT / "workflow" / "Snakefile"))
    jobs = planned(imported(tmp_path / "own", path, "my_*", "--dry-run", "my_all"))
    alone = planned(dry_run(tmp_path, changed(tmp_path)))
    assert {name.removeprefix("my_"): n for name, n in jobs.items()} == alone
    assert jobs["my_ksweep"] == 1


def test_a_hosted_repository_runs_in_the_importer_s_folder(tmp_path, hosted):
    done = imported(tmp_path / "own", hosted, "my_*", TARGET)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "own" / TARGET).exists()
    assert not (tmp_path / "hosted" / "results").exists()
    again = forked(tmp_path / "own", "--workflow-profile", "none", "--cores", "1", TARGET)
    assert "Nothing to be done" in again.stdout + again.stderr


ALONE = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {absent}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
from snakemake.cli import main
main()
"""


def test_rules_are_read_and_linted_beside_snakemake_alone(tmp_path):
    absent = {"numpy", "scipy", "numba", "cv2", "pycolmap", "safetensors", "plyfile", "PIL"}
    absent |= {"filelock", "pandas", "pyarrow", "matplotlib", "torch", "tqdm"}
    words = ["--lint", "--snakefile", str(ROOT / "workflow" / "Snakefile")]
    words += ["--configfile", str(changed(tmp_path)), "--workflow-profile", "none"]
    program = [sys.executable, "-W", "ignore", "-c", ALONE.format(absent=absent)]
    done = subprocess.run([*program, *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Congratulations" in done.stdout + done.stderr
