"""Cases by their seeds: a damaged capture or an odd command line, run and judged."""

import contextlib
import hashlib
import io
import json
import shutil
import signal
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from layout_recordings import recording
from small_captures import camera_path, ring, write_ring

from fsel.cli import main
from fsel.layouts import LAYOUTS, read_capture

from . import mutators

FRAMES = 9
LONGEST = 20  # seconds
LAYOUT_NAMES = (
    "ring", "colmap", "dl3dv", "mipnerf360", "nerfstudio", "scannetpp_dslr", "scannetpp_iphone",
    "seven_scenes", "scannet", "co3d",
)  # fmt: skip
LINES = [
    ["-k", "{}"], ["--long-side", "{}"], ["--seed", "{}"], ["--threshold", "{}"],
    ["--method", "{}"],
    ["--memory", "{}GB"], ["--memory", "{}"], ["--targets", "{}"], ["--targets", "every:{}"],
    ["--max-error", "{}"], ["--layout", "{}"], ["--masks", "{}"], ["-o", "{}"],
    ["--box", "{}", "0", "0", "1", "1", "1"],
]  # fmt: skip
VALUES = ["0", "-1", "1e-1", "-1e-1", "nan", "inf", "1e400", "x", "", "9" * 30, "../x", "auto", "."]


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes:
        layout: of the capture, or `lines` for command lines, or `path` for camera paths.
        seed: of all that is drawn.
        kept: which of the damages are done; None for all.
    """

    layout: str
    seed: int
    kept: tuple[int, ...] | None = None

    @property
    def damages(self):
        """How many damages there are."""
        return int(np.random.default_rng([self.seed, 1]).integers(1, 4))


class Hang(Exception):
    """A command took too long."""


def originals(folder):
    """Write an undamaged capture of each layout."""
    for name in LAYOUT_NAMES:
        if name == "ring":
            write_ring(folder / name, frames=FRAMES, cloud=20)
        else:
            LAYOUTS[name].write(recording(name, FRAMES), folder / name)
    camera_path(folder, ring(4))


def run(case, original, work):
    """What is wrong with the outcome, in words; nothing where all is as promised."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    if case.layout == "lines":
        return _of_line(case, original, work)
    capture = work / "capture"
    source = original / ("ring" if case.layout == "path" else case.layout)
    shutil.copytree(source, capture)
    target = original / "path.json"
    if case.layout == "path":
        target = Path(shutil.copy(target, work))
    for number in range(case.damages):
        if case.kept is None or number in case.kept:
            rng = np.random.default_rng([case.seed, 2, number])
            files = _files(capture) if case.layout != "path" else [target] * target.is_file()
            if files:
                chosen = files[rng.integers(len(files))]
                mutators.damage(chosen, rng)
    before = _digest(work)
    asked = ["--targets", str(target)] if case.layout == "path" else []
    select = ["select", str(capture), "-k", "3", *asked, "-o", str(work / "out"), "--quiet"]
    outcomes = {"select": _outcome(lambda: _command(select))}
    if case.layout != "path":
        outcomes["info"] = _outcome(lambda: _command(["info", str(capture), "--quiet"]))
        outcomes["read_capture"] = _outcome(lambda: read_capture(capture))
    shutil.rmtree(work / "out", ignore_errors=True)
    wrong = [f"{name}: {text}" for name, (kind, text) in outcomes.items() if kind == "wrong"]
    refused = {text for kind, text in outcomes.values() if kind == "refused"}
    wrong += [f"names no file: {text}" for text in refused if str(work) not in text]
    wrong += [f"of several lines: {text}" for text in refused if "\n" in text]
    if not wrong and refused and not _alike(outcomes):
        wrong.append(f"not alike: {outcomes}")
    if _digest(work) != before:
        wrong.append("the input was changed, or something was left")
    return wrong


def _alike(outcomes):
    """One line for all; `select` alone may refuse what it cannot export or has too little of."""
    own = ("no counterpart in transforms.json", "leave nothing to select", "allowed: 1 to")
    if outcomes["select"][0] == "refused" and any(text in outcomes["select"][1] for text in own):
        outcomes = {name: found for name, found in outcomes.items() if name != "select"}
    return len(set(outcomes.values())) <= 1


def _of_line(case, original, work):
    rng = np.random.default_rng([case.seed, 3])
    words = []
    for _ in range(int(rng.integers(1, 3))):
        value = VALUES[rng.integers(len(VALUES))]
        words += [word.format(value) for word in LINES[rng.integers(len(LINES))]]
    line = ["select", str(original / "ring"), "-k", "3", "--quiet", "-o", str(work / "out"), *words]
    before = _digest(original)
    with contextlib.chdir(work):
        kind, text = _outcome(lambda: _command(line))
    wrong = [f"{words}: {text}"] if kind == "wrong" else []
    if kind == "refused" and "\n" in text:
        wrong.append(f"{words}: of several lines: {text}")
    return wrong + ["the input was changed"] * (_digest(original) != before)


def _command(line):
    """Raises what the command refused, in its words; an odd command line is no refusal."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            code = main(line)
        except SystemExit as stop:
            code = 0 if stop.code == 2 else 3
    if code:
        raise ValueError(said.getvalue().removeprefix("fsel: ").rstrip("\n"))


def _outcome(work):
    """(kind, text): done, refused in words, or wrong."""
    started = time.monotonic()
    previous = signal.signal(signal.SIGALRM, _hang)
    signal.alarm(LONGEST)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            work()
    except (ValueError, OSError) as error:
        text = str(error)
        return ("refused", text) if time.monotonic() - started < LONGEST else ("wrong", "slow")
    except Exception as error:
        return "wrong", f"{type(error).__name__}: {error}"
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)
    return "done", ""


def _hang(number, frame):
    raise Hang(f"more than {LONGEST} seconds")


def _files(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _digest(folder):
    total = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        total.update(str(path.relative_to(folder)).encode())
        if path.is_file():
            total.update(path.read_bytes())
    return total.hexdigest()


def shrunk(case, original, work):
    """The case with as few of its damages as still go wrong."""
    if case.layout == "lines":
        return case
    kept = list(range(case.damages)) if case.kept is None else list(case.kept)
    for number in list(kept):
        fewer = Case(case.layout, case.seed, tuple(n for n in kept if n != number))
        if fewer.kept and run(fewer, original, work):
            kept.remove(number)
    return Case(case.layout, case.seed, tuple(kept))


def drawn(count, seed):
    """Cases of all layouts in turn, and of paths and command lines."""
    kinds = (*LAYOUT_NAMES, "path", "lines")
    return [Case(kinds[i % len(kinds)], seed + i) for i in range(count)]


def stored(path):
    """Cases that went wrong once."""
    return [Case(*entry[:2], None if entry[2] is None else tuple(entry[2]))
            for entry in json.loads(path.read_text())]  # fmt: skip
