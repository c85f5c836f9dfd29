"""Cases by their seeds: damaged inputs or an odd command line, run and judged."""

import contextlib
import hashlib
import json
import shutil
from dataclasses import dataclass, field

import numpy as np

from fsel.captures.read import read_capture

from . import changes, mutators, originals
from .outcomes import command, faults, outcome

LINES = [
    ["-k", "{}"], ["--long-side", "{}"],
    ["--method", "{}"],
    ["--vram", "{}GB"], ["--vram", "{}"], ["--targets", "{}"], ["--targets", "every:{}"],
    ["--max-error", "{}"], ["--layout", "{}"], ["--masks", "{}"], ["-o", "{}"],
    ["--box", "{}", "0", "0", "1", "1", "1"], ["--patience", "{}"],
]  # fmt: skip
VALUES = ["0", "-1", "1e-1", "-1e-1", "nan", "inf", "1e400", "x", "", "9" * 30, "../x", "auto", "."]


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes:
        kind: one of `originals.KINDS`.
        seed: of all that is drawn.
        changes: what is changed in place of what the seed says, see `changes`; None for that.
    """

    kind: str
    seed: int
    changes: dict | None = field(default=None, hash=False)

    def damage(self, folder):
        """Damage the copy of an original."""
        if self.changes is not None:
            changes.done(self.changes, folder)
            return
        place = folder / originals.BESIDE.get(self.kind, "capture")
        for number in range(np.random.default_rng([self.seed, 1]).integers(1, 4)):
            rng = np.random.default_rng([self.seed, 2, number])
            found = [place] if place.is_file() else place.rglob("*")
            files = sorted(path for path in found if path.is_file() and not path.is_symlink())
            if files:
                mutators.damage(files[rng.integers(len(files))], rng)


def run(case, original, work):
    """What is wrong with the outcome, in words; nothing where all is as promised."""
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(original / case.kind, work)
    if case.kind == "lines":
        return _of_line(case, work)
    case.damage(work)
    before = _digest(work)
    lines = originals.commands(case.kind, work, np.random.default_rng([case.seed, 3]))
    found = {}
    for name, line in lines.items():
        found[name] = outcome(lambda line=line: command(line))
        _remove(work / "out", work / "out.ply")
    if case.kind not in originals.BESIDE:
        found["read_capture"] = outcome(lambda: read_capture(work / "capture"))
    # what is beside a capture is read by each command for another purpose
    wrong = faults(found, work, alike=case.kind not in originals.BESIDE)
    if _digest(work) != before:
        wrong.append("the input was changed, or something was left")
    return wrong


def warm_up(kinds, original, work):
    """Run every command on undamaged inputs, however long it takes: kernels are compiled then."""
    for kind in kinds:
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(original / kind, work)
        for line in originals.commands(kind, work).values():
            command(line)
            _remove(work / "out", work / "out.ply")


def _of_line(case, work):
    rng = np.random.default_rng([case.seed, 3])
    words = []
    for _ in range(int(rng.integers(1, 3))):
        value = VALUES[rng.integers(len(VALUES))]
        words += [word.format(value) for word in LINES[rng.integers(len(LINES))]]
    line = ["select", str(work / "capture"), "-k", "3", "--quiet", "-o", str(work / "out"), *words]
    before = _digest(work / "capture")
    (work / "here").mkdir()
    with contextlib.chdir(work / "here"):
        kind, text = outcome(lambda: command(line))
    wrong = [f"{words}: {text}"] if kind == "wrong" else []
    if kind == "refused" and "\n" in text:
        wrong.append(f"{words}: of several lines: {text}")
    return wrong + ["the input was changed"] * (_digest(work / "capture") != before)


def _remove(*paths):
    for path in paths:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def _digest(folder):
    total = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        total.update(str(path.relative_to(folder)).encode())
        if path.is_file():
            total.update(path.read_bytes())
    return total.hexdigest()


def drawn(count, seed):
    """Return cases of all kinds in turn."""
    kinds = originals.KINDS
    return [Case(kinds[i % len(kinds)], seed + i) for i in range(count)]


def stored(path):
    """Cases that went wrong once."""
    return [Case(kind, seed, done) for kind, seed, done in json.loads(path.read_text())]
