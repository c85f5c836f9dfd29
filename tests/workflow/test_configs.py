"""Broken config files are named with the line of their fault."""

import subprocess
import sys
from pathlib import Path

import pytest

from fsel.workflow.configs import refuse_broken

ROOT = Path(__file__).parents[2]
BROKEN = {
    b"seed: 0\nroots: [1, 2\nnext: 3\n": ", line 3, column 5: while parsing a flow sequence: ",
    b"seed: 0\n\tx: 1\n": ", line 2, column 1: while scanning for the next token: ",
    b"a: 1\nb: c: 2\n": ", line 2, column 5: mapping values are not allowed here",
    "seed: 0\n".encode("utf-16"): ": not a text in UTF-8 (byte 0)",
    b"- 1\n": ": holds no keys at its top level",
    b"a: \x07\n": ": not readable as YAML (",
    b"": ": holds no keys at its top level",
}


@pytest.mark.parametrize("content", BROKEN)
def test_the_fault_of_a_config_is_told_with_its_place(content, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    for option in (["--configfile", str(path)], [f"--configfiles={path}"]):
        with pytest.raises(SystemExit) as refused:
            refuse_broken(["-n", "all", *option])
        assert str(refused.value).startswith(f"{path}{BROKEN[content]}")


@pytest.mark.parametrize("content", ["a: 1\n", '{\n\t"a": 1\n}'])
def test_whole_configs_pass_and_those_that_are_not_there(content, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(content)
    refuse_broken(["-n", "--configfile", str(path), str(tmp_path / "none.yaml"), "--cores", "2"])
    refuse_broken(["-n", "--config", "seed=1"])


@pytest.mark.parametrize("profile", [[], ["--workflow-profile", "profiles/slurm"]])
def test_snakemake_says_the_line(profile, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("seed: 0\nroots: [1, 2\nnext: 3\n")
    line = [sys.executable, "-m", "snakemake", "-n", *profile, "--configfile", str(path)]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    said = [text for text in done.stderr.splitlines() if not text.startswith("Using ")]
    assert len(said) == 1
    assert said[0].startswith(f"{path}, line 3, column 5: ")
