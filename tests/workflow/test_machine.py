"""Which variables jobs get on which processors, and that the libraries obey them."""

import json
import os
from pathlib import Path

import pytest
from own_python import printed

from fsel.workflow import machine
from fsel.workflow.machine import LEVEL, PINNED, WIDE, pinned

SHOWN = """
import json
import cv2
import numba
from numpy._core._multiarray_umath import __cpu_features__ as numpy_has
from numba.core.registry import cpu_target
print(json.dumps({
    "numba": cpu_target.target_context.codegen().magic_tuple()[1:],
    "numpy": [name for name, there in numpy_has.items() if there],
    "opencv": cv2.getCPUFeaturesLine(),
    "ipp": cv2.ipp.getIppVersion(),
}))
"""


@pytest.mark.parametrize(
    ("processor", "flags", "found"),
    [
        ("x86_64", LEVEL | WIDE, PINNED),
        ("x86_64", LEVEL, {k: v for k, v in PINNED.items() if k != "OPENCV_CPU_DISABLE"}),
        *(("x86_64", LEVEL - {lacking}, {}) for lacking in sorted(LEVEL)),
        ("x86_64", None, PINNED),  # no list of features
        ("aarch64", LEVEL, {}),
    ],
)
def test_only_processors_of_level_three_are_pinned(monkeypatch, tmp_path, processor, flags, found):
    monkeypatch.setattr(machine.platform, "machine", lambda: processor)
    path = tmp_path / "cpuinfo"
    if flags is not None:
        path.write_text(f"processor : 0\nflags\t\t: fpu {' '.join(sorted(flags))}\nbugs : none\n")
    assert pinned(path) == found


def test_a_variable_that_is_set_is_kept_and_told(monkeypatch, capsys):
    monkeypatch.setattr(machine.os, "environ", {"OPENBLAS_CORETYPE": "SkylakeX", "PYTHONPATH": "b"})
    monkeypatch.setattr(machine, "pinned", lambda: PINNED)
    machine.prepare(Path("a"), verbose=True)
    search = os.pathsep.join([os.path.join("a", "src"), "b"])
    kept = {**PINNED, "OPENBLAS_CORETYPE": "SkylakeX", "PYTHONPATH": search, "FSEL": "a[workflow]"}
    assert machine.os.environ == {**machine.INHERITED, **kept}
    assert "OPENBLAS_CORETYPE is set to 'SkylakeX'" in capsys.readouterr().err
    machine.prepare(None)  # the installed library, in a job's process
    assert capsys.readouterr().err == ""
    assert machine.os.environ["PYTHONPATH"] == search
    assert machine.os.environ["FSEL"].startswith("fsel[workflow]==")


@pytest.mark.skipif(not pinned(), reason="the processor is not of x86-64-v3")
def test_libraries_obey():
    shown = json.loads(printed(SHOWN, **pinned()))
    assert shown["numba"] == ["haswell", ""]
    # what NumPy dispatches by; the processor's single features stay listed
    assert not {"X86_V4", "AVX512_ICL", "AVX512_SPR"} & set(shown["numpy"])
    assert not shown["opencv"].endswith("*AVX512-SKX")
    assert "AVX-512" not in shown["ipp"]
