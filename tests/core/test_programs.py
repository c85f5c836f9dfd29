"""Programs that are run: how they may end, and what they are given."""

import os
import sys
from contextlib import ExitStack

import pytest

from fsel.core.programs import Unfinished, environment, run, running, tail


def ended(folder, text, timeout=60):
    with pytest.raises(Unfinished) as failure:
        run([sys.executable, "-c", text], folder, environment(None), timeout)
    return failure.value


@pytest.mark.parametrize(
    ("text", "outcome", "said"),
    [
        ("print('working', flush=True); 1 / 0", "failed", "exit code 1\nworking\nTrace"),
        ("raise MemoryError", "out of memory", "exit code 1"),
        ("print('CUDA out of memory.'); exit(3)", "out of memory", "exit code 3"),
        ("import os, signal; os.kill(os.getpid(), 9)", "out of memory", "was killed"),
    ],
)
def test_how_a_program_may_end(tmp_path, text, outcome, said):
    failure = ended(tmp_path, text)
    assert failure.outcome == outcome
    assert said in str(failure)


def test_a_program_that_takes_too_long_is_ended(tmp_path):
    assert ended(tmp_path, "import time; time.sleep(600)", timeout=0.5).outcome == "timeout"


def test_a_program_is_ended_with_its_children(tmp_path):
    """A pipe ends with the last process that may write to it."""
    os.mkfifo(tmp_path / "pipe")
    child = f"import time; pipe = open({str(tmp_path / 'pipe')!r}, 'w'); time.sleep(600); 1 / 0"
    text = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])"
    with ExitStack() as opened:
        with running([sys.executable, "-c", text], tmp_path, environment(None)):
            pipe = opened.enter_context(open(tmp_path / "pipe"))  # begun
        assert pipe.read() == ""
    assert tail(tmp_path) == ""


def test_a_program_has_its_own_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/this/process")
    (tmp_path / "bin").mkdir()
    tool = tmp_path / "bin" / "tool"
    tool.write_text('#!/bin/sh\necho "path=$PYTHONPATH venv=$VIRTUAL_ENV all=$*"\n')
    tool.chmod(0o755)
    run([str(tool), "$HOME; *"], tmp_path, environment(str(tmp_path)), 60)
    assert tail(tmp_path) == f"path= venv={tmp_path} all=$HOME; *"
