"""Command lines with odd values, signals before work starts, and who speaks on standard error."""

import json
import signal
import subprocess
import sys

import numpy as np
import pytest
from small_captures import select, write_ring

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
        timeout=25,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert done.returncode == code
    assert done.stderr == "fsel: interrupted, nothing was written\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--long-side", "0"], "--long-side: 0 is out of range; allowed: 1 to 16384"),
        (["--long-side", "1" * 12], "allowed: 1 to 16384"),
        (["--cover", "0"], "--cover: 0 is out of range"),
        (["--vram", "infGB"], "--vram: 'infGB' is no size"),
        (["--vram=-1GB"], "--vram: '-1GB' is no size"),
        (["--max-error", "nan"], "--max-error: 'nan' is out of range"),
    ],
)
def test_values_out_of_range_are_named(words, said, capsys):
    with pytest.raises(SystemExit) as stop:
        parsed(["select", "capture", "-k", "3", "-o", "out", *words])
    assert stop.value.code == 2
    assert said in capsys.readouterr().err


def test_negative_exponents_are_numbers():
    box = ["-1e-1", "-2.5E+1", "-.5e0", "1e-1", "3", "4"]
    asked = parsed(["select", "capture", "-k", "3", "-o", "out", "--box", *box])
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
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    bad = [sys.executable, "-c", script, "info", str(tmp_path / "gone")]
    done = subprocess.run(bad, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (1, f"fsel: {tmp_path}/gone: no such folder\n")


def test_cameras_in_one_place_are_drawn_in_the_middle(tmp_path):
    """They turn in place: nothing tells how far apart they are."""
    write_ring(tmp_path / "ring", frames=9, cloud=0)
    frames = []
    for i, turn in enumerate(np.radians(np.arange(0, 90, 10))):
        matrix = np.eye(4)
        matrix[0, 0] = matrix[2, 2] = np.cos(turn)
        matrix[0, 2], matrix[2, 0] = np.sin(turn), -np.sin(turn)
        frames.append(
            {"file_path": f"images/frame_{i:03d}.jpg", "transform_matrix": matrix.tolist()}
        )
    content = {"w": 64, "h": 48, "fl_x": 60, "frames": frames}
    (tmp_path / "ring" / "transforms.json").write_text(json.dumps(content))
    asked = ["-k", 3, "--layout", "nerfstudio", "--quiet", "-o", tmp_path / "out"]
    (tmp_path / "ring" / "sparse").rename(tmp_path / "model")
    assert select(tmp_path / "ring", *asked) == 0
    assert "nan" not in (tmp_path / "out" / "report.html").read_text().partition("data:image")[0]
