"""Jobs as forks: what they inherit, and how they fail."""

import os
import subprocess
import sys

import pytest

from fsel.workflow import forks

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="jobs are forked on Linux alone")


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    for module, name in (
        (forks.script, "PythonScript"),
        (forks.benchmark, "BENCHMARK_INTERVAL_SHORT"),
    ):
        monkeypatch.setattr(module, name, getattr(module, name))
    forks.fork_jobs(forks.MANY)
    assert os.environ["OMP_NUM_THREADS"] == "7"

    def run(text):
        file = tmp_path / "script.py"
        file.write_text(text)
        job = forks.script.PythonScript.__new__(forks.script.PythonScript)
        job.conda_env = job.container_img = job.env_modules = job.bench_record = None
        job.threads, job.resources = 1, {"tmpdir": str(tmp_path)}
        job.execute_script(str(file))

    return run


def test_a_script_finds_what_was_imported_one_thread_and_its_folder(run, tmp_path):
    run(
        "import os, sys, tempfile\n"
        "from pathlib import Path\n"
        "assert {'numba', 'cv2', 'fsel.stages.label'} <= set(sys.modules)\n"
        "said = [os.environ['OMP_NUM_THREADS'], tempfile.gettempdir(), __name__]\n"
        f"Path({str(tmp_path / 'said')!r}).write_text(' '.join(said))\n"
        "os._exit(0)\n"
    )
    assert (tmp_path / "said").read_text() == f"1 {tmp_path} __main__"


@pytest.mark.parametrize(
    ("text", "code"),
    [("raise SystemExit(143)", 143), ("1 / 0", 1), ("import os; os.kill(os.getpid(), 9)", -9)],
)
def test_a_script_that_fails_fails_its_job(run, text, code):
    with pytest.raises(subprocess.CalledProcessError) as failure:
        run(text)
    assert failure.value.returncode == code
