"""Command lines with odd values, signals before work starts, and who speaks on standard error."""

import signal
import subprocess
import sys
from argparse import ArgumentTypeError

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_captures import pose_anew, select, write_ring

from fsel.cli.options import size_in_bytes, words
from fsel.cli.parser import parsed

STOPPED = """
import os, sys, time

class Stopping:
    def find_spec(self, name, path=None, target=None):
        if name == "MODULE":
            os.kill(os.getpid(), NUMBER)
            time.sleep(0.2)

sys.meta_path.insert(0, Stopping())
from fsel.cli import main
sys.exit(main(["info", "nowhere"]))
"""


# before, amid and after the import of pycolmap, which takes the signal TERM to itself
@pytest.mark.parametrize("module", ["fsel.cli.parser", "numpy", "fsel.captures.read"])
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_amid_imports_is_one_line(number, code, module):
    script = STOPPED.replace("NUMBER", str(int(number))).replace("MODULE", module)
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=6000,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert done.returncode == code
    assert done.stderr == "fsel: interrupted, nothing was written\n"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("--long-side 0", ["--long-side: 0 is out of range; allowed: 1 to 16384"]),
        ("--long-side 111111111111", ["allowed: 1 to 16384"]),
        ("--vram infGB", ["--vram: 'infGB' is not a size"]),
        ("--vram=-1GB", ["--vram: '-1GB' is not a size"]),
        ("--vram 8X", ["--vram", "8GB"]),
        ("--max-error nan", ["--max-error: 'nan' is out of range"]),
        ("-k ten", ["-k", "'ten'", "allowed: a whole number, or auto"]),
        ("--rate x", ["--rate", "'x'", "allowed: more than 0"]),
        ("--link --long-side 32", ["--long-side", "--link"]),
        ("--box 0 0 0 1 1 1 --masks m", ["--masks", "--box"]),
    ],
)
def test_values_that_make_no_sense_are_named(given, said, capsys):
    with pytest.raises(SystemExit) as stop:
        parsed(["select", "capture", "-k", "3", "-o", "out", *given.split()])
    assert stop.value.code == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert all(part in error for part in said), error


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("selct capture -k 3", "select"),
        ("select capture -k 3 -o out --trget every:8", "--targets"),
        ("select capture -k 3 --ouput out", "--out"),
    ],
)
def test_a_typo_is_answered_with_what_was_meant(line, meant, capsys):
    with pytest.raises(SystemExit) as stop:
        parsed(line.split())
    said = capsys.readouterr().err
    assert (stop.value.code, len(said.splitlines())) == (2, 2)
    assert f"Did you mean {meant}?" in said


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("8G", 8 * 10**9),
        ("8GiB", 8 * 2**30),
        ("1.5 TB", 15 * 10**11),
        ("512mib", 2**29),
        ("77B", 77),
    ],
)
def test_sizes_are_read_as_people_write_them(text, size):
    assert size_in_bytes(text) == size


def test_words_between_commas_are_read_as_people_write_them():
    assert words("fsel, uniform,,fsel,") == ["fsel", "uniform"]
    with pytest.raises(ArgumentTypeError, match="is empty"):
        words(" ,")


def test_negative_exponents_are_numbers():
    box = ["-1e-1", "-2.5E+1", "-.5e0", "1e-1", "3", "4"]
    asked = parsed(["select", "capture", "-k", "3", "-o", "out", "--box", *box])
    assert asked.poses == "layout"
    assert asked.box == [-0.1, -25, -0.5, 0.1, 3, 4]


def test_libraries_do_not_speak_before_the_command(tmp_path):
    """libjpeg has a line about damage that it passes over."""
    write_ring(tmp_path / "ring", frames=9, cloud=30)
    for path in (tmp_path / "ring" / "images").iterdir():
        content = bytearray(path.read_bytes())
        middle = content.index(b"\xff\xda") + 40
        content[middle : middle + 8] = bytes(8)
        path.write_bytes(content)
    script = "import sys; from fsel.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", script, "info", str(tmp_path / "ring"), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")


def test_cameras_in_one_place_are_told_and_drawn_in_the_middle(tmp_path, capsys):
    """They turn in place: nothing tells how far apart they are."""
    write_ring(tmp_path / "ring", frames=9, cloud=0)
    turns = Rotation.from_euler("y", np.arange(0, 90, 10)[:, None], degrees=True).as_matrix()
    pose_anew(tmp_path / "ring", [np.column_stack([turn, np.zeros(3)]) for turn in turns])
    assert select(tmp_path / "ring", "-k", 3, "-o", tmp_path / "out") == 0
    assert "9 cameras are at one place" in capsys.readouterr().err
    assert "nan" not in (tmp_path / "out" / "report.html").read_text().partition("data:image")[0]
