"""Programs that are run: how they may end, and what they are given."""

import sys
import time

import pytest

from fsel.core.programs import Unfinished, environment, run, tail


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


def test_a_program_that_takes_too_long_is_ended_with_its_children(tmp_path):
    child = f"import time; time.sleep(6); open({str(tmp_path / 'late')!r}, 'w')"
    text = (
        "import subprocess, sys, time; print('begun', flush=True); "
        f"subprocess.Popen([sys.executable, '-c', {child!r}]); time.sleep(60)"
    )
    started = time.monotonic()
    failure = ended(tmp_path, text, timeout=4)
    assert (failure.outcome, failure.log) == ("timeout", "begun")
    assert time.monotonic() - started < 20
    time.sleep(2.5)
    assert not (tmp_path / "late").exists()


def test_a_program_has_its_own_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/this/process")
    (tmp_path / "bin").mkdir()
    tool = tmp_path / "bin" / "tool"
    tool.write_text('#!/bin/sh\necho "path=$PYTHONPATH venv=$VIRTUAL_ENV all=$*"\n')
    tool.chmod(0o755)
    run([str(tool), "$HOME; *"], tmp_path, environment(str(tmp_path)), 60)
    assert tail(tmp_path) == f"path= venv={tmp_path} all=$HOME; *"
